#pragma once

#include <span>

#include "core/samples/sample_tile.h"

namespace relume {

/// A sample where it lies, whatever its type: its vector and the first float of its normal, or -1.
struct PlacedSample {
  const float* vector;
  int normal;
};

/// Appends the footprint of a record with its anchor at `anchor` that stands for `members`, all of
/// equal weight, and up to `stored` of them, evenly spread in sampling order: in footprints and
/// members of `out`. Of a record without members or with one, nothing is stored but that.
void append_footprint(std::span<const PlacedSample> members, vec3 anchor, int stored,
                      TypedRows& out);

}  // namespace relume
