#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace relume {

inline constexpr float largest_half = 65504;

/// The 16-bit float nearest to `x`, ties to even, as a 32-bit one; beyond their range the largest.
/// Infinite x becomes the largest, not-a-number stays.
inline float nearest_half(float x) {
  if (!(std::abs(x) < largest_half)) return std::isnan(x) ? x : std::copysign(largest_half, x);
  constexpr float smallest_normal = 0x1p-14f;
  if (std::abs(x) < smallest_normal) return std::nearbyint(x * 0x1p24f) * 0x1p-24f;
  const auto bits = std::bit_cast<uint32_t>(x);
  constexpr uint32_t dropped = 13;
  const uint32_t to_even = (bits >> dropped) & 1;
  const uint32_t half_step = (1u << (dropped - 1)) - 1;
  return std::bit_cast<float>((bits + half_step + to_even) & ~((1u << dropped) - 1));
}

}  // namespace relume
