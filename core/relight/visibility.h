#pragma once

#include <span>

#include "core/samples/pixel_share.h"
#include "core/scene/light.h"

namespace relume {

/// Points that ask for visibility: `count` receivers, coordinates in separate arrays (world space).
struct Receivers {
  int count = 0;
  size_t first = 0;               ///< index of the first among all of its view, see ViewReceivers
  const float* weight = nullptr;  ///< 0 = padding: the answer is not used
  const float* position[3] = {};  ///< anchors
  const float* normal[3] = {};    ///< unit, faces the eye; all null on strands
  const float* bias = nullptr;    ///< see core/trace/ray_bias.h
  bool lit_from_behind = false;   ///< false: light from behind the normal does not count
};

/// What the relight engine asks of a shadow method (module shadow implements it). prepare() is
/// called from one thread whenever the light moved; the others then from many threads at once. A
/// method either answers any receiver that comes, or learned those of one view when it was made
/// (ViewReceivers) and knows them by index.
class VisibilitySource {
 public:
  virtual ~VisibilitySource() = default;

  /// Makes ready for queries about `light`.
  virtual void prepare(const Light& light) = 0;
  /// The same where only receivers of a share of the pixels will be asked for: less work for
  /// methods that do it here. Their answers may differ a little from those of prepare().
  virtual void prepare_share(const Light& light, PixelShare /*share*/) { prepare(light); }

  /// Writes the fraction of each receiver that sees the light, in [0, 1], to visibility[0, count).
  /// Padding receivers get an unspecified finite value. Const, thread-safe, no allocation.
  virtual void visibility(const Receivers& receivers, float* visibility) const = 0;

  /// The same for all receivers of the view, by index, where prepare() did the work; else empty.
  /// Then no record is decoded to ask for it. Valid until the next prepare().
  virtual std::span<const float> all_visibility() const { return {}; }

  /// What the method keeps beside the scene and its ray tracer.
  virtual uint64_t memory_bytes() const { return 0; }
};

}  // namespace relume
