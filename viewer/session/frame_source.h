#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/relight/relight.h"
#include "core/trace/tracer.h"
#include "shadow/shadow.h"

namespace relume {

/// One frame to compute.
struct RelightRequest {
  std::vector<Light> lights;
  ShadowMethod shadows = ShadowMethod::ray;
};

/// One frame computed, or the reason why not.
struct RelitFrame {
  RelightRequest request;  ///< what it shows
  Image image;             ///< scene-linear RGB; stale when error is not empty
  RelightStats stats;
  double ms = 0;      ///< wall time from taking the request to the finished image
  std::string error;  ///< one line; empty = ok
};

/// Computes frames of one view. Used by one thread at a time.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// Fills frame.image and frame.stats. Throws Error.
  virtual void render(const RelightRequest& request, RelitFrame& frame) = 0;
};

/// Relights `cache`. With `shadows` given it is used instead of the request's. Without a tracer
/// only ShadowMethod::none works; any other throws Error(input). The tracer must outlive the
/// source.
std::unique_ptr<FrameSource> make_cache_source(RelightCache cache, const Tracer* tracer,
                                               std::optional<ShadowMethod> shadows = {});

}  // namespace relume
