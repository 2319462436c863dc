#pragma once

#include <array>
#include <cstdint>

namespace relume {

/// Philox4x32-10 (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011): 128
/// random bits that are a pure function of counter and key. Four values per call, no state, so any
/// thread may compute any element and the result never depends on the number of threads.
constexpr std::array<uint32_t, 4> philox(std::array<uint32_t, 4> counter,
                                         std::array<uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const uint64_t product0 = uint64_t{0xD2511F53u} * counter[0];
    const uint64_t product1 = uint64_t{0xCD9E8D57u} * counter[2];
    counter = {static_cast<uint32_t>(product1 >> 32) ^ counter[1] ^ key[0],
               static_cast<uint32_t>(product1),
               static_cast<uint32_t>(product0 >> 32) ^ counter[3] ^ key[1],
               static_cast<uint32_t>(product0)};
    key[0] += 0x9E3779B9u;
    key[1] += 0xBB67AE85u;
  }
  return counter;
}

/// A float in [0, 1) with 24 random bits.
constexpr float unit_float(uint32_t bits) {
  return static_cast<float>(bits >> 8) * 0x1p-24f;
}

/// What a stream of random numbers is for; streams never overlap.
enum class RandomStream : uint32_t {
  pixel_samples = 1,
  reduction = 2,
  lights = 3,
  scatter = 4,
  strands = 5,
  tests = 6,
  planning = 7,
};

/// A sequence of random numbers for one (seed, stream, index) triple, for instance one pixel,
/// strand or trial. Draw in separate statements: the order of draws inside one expression is
/// unspecified.
class Random {
 public:
  constexpr Random(uint64_t seed, RandomStream stream, uint64_t index)
      : key_{static_cast<uint32_t>(seed), static_cast<uint32_t>(seed >> 32)},
        counter_{0, static_cast<uint32_t>(stream), static_cast<uint32_t>(index),
                 static_cast<uint32_t>(index >> 32)} {}

  constexpr uint32_t bits() {
    if (used_ == 4) {
      block_ = philox(counter_, key_);
      ++counter_[0];
      used_ = 0;
    }
    return block_[used_++];
  }

  /// Uniform in [0, 1).
  constexpr float uniform() { return unit_float(bits()); }
  /// Uniform in [low, high).
  constexpr float uniform(float low, float high) { return low + (high - low) * uniform(); }
  /// Uniform integer in [0, n), n > 0 (multiply-shift; bias below n / 2^32).
  constexpr uint32_t below(uint32_t n) {
    return static_cast<uint32_t>((uint64_t{bits()} * n) >> 32);
  }

 private:
  std::array<uint32_t, 2> key_;
  std::array<uint32_t, 4> counter_;
  std::array<uint32_t, 4> block_{};
  int used_ = 4;
};

}  // namespace relume
