#pragma once

#include <array>
#include <cstdint>

#include "core/math/vec.h"

namespace relume {

/// Where the samples lie that a record stands for: their mean and spread. Shadow methods ask for
/// the part of it that sees the light. A single sample has no extent.
struct Footprint {
  vec3 offset{0};  ///< world: mean of the members' positions, from the record's anchor
  /// World, squared: of the members' positions about their mean; xx, xy, xz, yy, yz, zz.
  std::array<float, 6> covariance{};
  int samples = 1;         ///< members, at least 1
  int stored_members = 0;  ///< see TypedRows::members
};

/// One sample that a record stands for.
struct Member {
  vec3 offset{0};  ///< world, from the record's anchor
  vec3 normal{0};  ///< unit, faces the eye; zero on strands
};

/// Samples of a footprint and stored members stop counting here.
inline constexpr int max_members = 255;

/// Words of a stored footprint: offset and the covariance's Cholesky factor as signed 16-bit
/// fractions of a power of two, that exponent, and the number of samples. Whatever the bits are,
/// they stand for finite numbers and a positive semidefinite covariance.
inline constexpr int footprint_words = 5;
using FootprintWords = std::array<uint32_t, footprint_words>;

/// Errors: 2^-15 of the largest of offset and standard deviations, for offset and factor. `samples`
/// is cut to max_members; stored_members is not part of the words.
FootprintWords encode_footprint(const Footprint& footprint);
Footprint decode_footprint(const FootprintWords& words);

/// A stored member: 16-bit fractions of `scale`, an octahedral normal of 8 bits each.
struct PackedMember {
  std::array<int16_t, 3> offset{};
  std::array<uint8_t, 2> normal{};
};
static_assert(sizeof(PackedMember) == 8);

/// `scale`: member_scale(), at least each |component| of the offset.
PackedMember encode_member(const Member& member, float scale);
/// `on_surface`: false gives a zero normal.
Member decode_member(const PackedMember& packed, float scale, bool on_surface);

/// A bound on the members' offsets from the anchor, from the footprint as it is stored: a member
/// lies within sqrt(n) standard deviations of the mean.
float member_scale(const Footprint& stored);

}  // namespace relume
