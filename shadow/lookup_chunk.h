#pragma once

#include "core/relight/visibility.h"
#include "shadow/lookup_kernel.h"

namespace relume {

/// Sixteen receivers on their way through lookups. What it points to is the receivers' own arrays
/// where all sixteen are there.
struct LookupChunk {
  const float* position[3];
  const float* bias;
  const float* normal[3];      ///< null on strands
  float lit[lookup_lanes];     ///< 1, or 0: padding, or the light cannot light it
  float passed[lookup_lanes];  ///< of the light, by all that was asked so far
  bool any_lit;
  bool lit_from_behind;
  int first;
  int count;

  /// Takes receivers [first_receiver, first_receiver + 16); lanes beyond the last repeat it,
  /// unlit.
  void load(const Receivers& all, int first_receiver);

  /// Sets lit, any_lit and passed = 1. `to_light`: unit, against the light's direction.
  void mark_lit(const Light& light, vec3 to_light, float cos_outer);

  LookupReceivers receivers() const {
    return {{position[0], position[1], position[2]}, bias, {normal[0], normal[1], normal[2]}};
  }

  /// All sixteen, weighted by `weights`.
  Receivers as_receivers(const float* weights) const;

  /// Writes visibility[first, first + count): passed, or 1 where not lit.
  void store(float* visibility) const;

 private:
  float copies_[7][lookup_lanes];
};

}  // namespace relume
