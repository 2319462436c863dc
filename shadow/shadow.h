#pragma once

#include <memory>

#include "core/relight/visibility.h"
#include "core/samples/relight_cache.h"
#include "core/trace/tracer.h"
#include "shadow/opacity.h"
#include "shadow/shadow_method.h"
#include "shadow/volume.h"

namespace relume {

struct ShadowParams {
  int member_rays = max_members;  ///< `members`: rays a receiver, at most; 1 or more
  OpacityParams opacity{};
  VolumeParams volume{};
};

/// The approximator for `method` (`automatic`: an AutomaticVisibility), for receivers of `cache`,
/// or null for `none`. Keeps references to tracer and cache. Throws Error(input) where the cache
/// lacks what the method needs.
std::unique_ptr<VisibilitySource> make_shadow(ShadowMethod method, const Tracer& tracer,
                                              const RelightCache& cache,
                                              const ShadowParams& params = {});

}  // namespace relume
