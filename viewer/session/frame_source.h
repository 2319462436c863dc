#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/relight/frame_cost.h"
#include "core/relight/relight.h"
#include "core/trace/tracer.h"
#include "shadow/shadow.h"

namespace relume {

/// One frame to compute.
struct RelightRequest {
  std::vector<Light> lights;
  ShadowMethod shadows = ShadowMethod::ray;
  PixelShare pixels = PixelShare::all;  ///< see RelightParams
  bool dragging = false;                ///< see RelightParams
  float frame_ms = 0;     ///< that a light move may take, for `automatic` shadows; 0: any time
  bool may_stop = false;  ///< a newer request ends it unfinished, since a picture is on the screen
};

/// One frame computed, or the reason why not.
struct RelitFrame {
  RelightRequest request;  ///< what it shows
  Image image;             ///< scene-linear RGB; stale when error is not empty
  RelightStats stats;
  FrameWork work;            ///< of stats, for FrameCost
  std::string shadows_used;  ///< of `automatic` shadows: the method, and why; else empty
  double ms = 0;             ///< wall time from taking the request to the finished image
  std::string error;         ///< one line; empty = ok
};

/// Computes frames of one view. Used by one thread at a time.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// Fills frame.image, frame.stats and frame.work. Throws Error; of kind cancelled soon after
  /// `cancelled` became true, if it looks at it.
  virtual void render(const RelightRequest& request, const std::atomic<bool>& cancelled,
                      RelitFrame& frame) = 0;

  /// The records that are relit; null where there are none.
  virtual const RelightCache* cache() const { return nullptr; }
};

/// Relights `cache`. With `shadows` given it is used instead of the request's. Without a tracer
/// only ShadowMethod::none works; any other throws Error(input). The tracer must outlive the
/// source.
std::unique_ptr<FrameSource> make_cache_source(RelightCache cache, const Tracer* tracer,
                                               std::optional<ShadowMethod> shadows = {});

}  // namespace relume
