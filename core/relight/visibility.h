#pragma once

#include "core/scene/light.h"

namespace relume {

/// Points that ask for visibility: `count` receivers, coordinates in separate arrays (world space).
struct Receivers {
  int count = 0;
  const float* weight = nullptr;  ///< 0 = padding: the answer is not used
  const float* position[3] = {};  ///< anchors
  const float* normal[3] = {};    ///< unit, faces the eye; all null on strands
  const float* bias = nullptr;    ///< see core/trace/ray_bias.h
  bool lit_from_behind = false;   ///< false: light from behind the normal does not count
};

/// What the relight engine asks of a shadow method (module shadow implements it). prepare() is
/// called from one thread whenever the light moved; visibility() then from many threads at once.
class VisibilitySource {
 public:
  virtual ~VisibilitySource() = default;

  /// Makes ready for queries about `light`.
  virtual void prepare(const Light& light) = 0;

  /// Writes the fraction of each receiver that sees the light, in [0, 1], to visibility[0, count).
  /// Padding receivers get an unspecified finite value. Const, thread-safe, no allocation.
  virtual void visibility(const Receivers& receivers, float* visibility) const = 0;
};

}  // namespace relume
