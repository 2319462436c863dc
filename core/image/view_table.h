#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/math/vec.h"

namespace relume {

/// Takes RGB triples from scene-linear to display values, in place, each by itself.
using ColorTransform = std::function<void(std::span<float> rgb)>;

/// A ColorTransform as a table of 82^3 values: four cells an octave from 2^-14 to 64 and one below,
/// to 0. It equals the transform at the corners of cells and is interpolated over tetrahedra
/// between them: a smooth transform comes within a code value of 8 bits; one that bends inside of a
/// cell, as where it clamps, is off there by what it bends. 8.8 MB. Immutable.
class ViewTable {
 public:
  /// Calls `transform`, on several threads, for 551,368 triples in all.
  explicit ViewTable(const ColorTransform& transform);

  /// All of the triple's channels are within [0, 64].
  static bool covers(const float* rgb);

  /// Triples in place. Channels below 0 and not-a-number count as 0, those above 64 as 64.
  void apply(std::span<float> rgb) const;

 private:
  std::vector<vec4> nodes_;  ///< red fastest, then green, then blue; the fourth value is 0
};

}  // namespace relume
