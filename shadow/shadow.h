#pragma once

#include <array>
#include <memory>

#include "core/base/label.h"
#include "core/relight/visibility.h"
#include "core/samples/relight_cache.h"
#include "core/trace/tracer.h"
#include "shadow/opacity.h"
#include "shadow/volume.h"

namespace relume {

/// Shadow approximators. `none` sees every light from everywhere; `ray` traces one ray a receiver,
/// from its anchor (TR2007-600 sec. 4.2); `members` traces rays from the samples that a receiver
/// stands for; `coverage` rasterises thin geometry from the light onto the receivers' footprints;
/// `opacity` draws it into maps of what the light sees first; `volume` cuts it into cells whose
/// coverage rays add up.
enum class ShadowMethod { none, ray, members, coverage, opacity, volume };

inline constexpr std::array shadow_method_labels = {
    Label<ShadowMethod>{ShadowMethod::none, "none"},
    Label<ShadowMethod>{ShadowMethod::ray, "ray"},
    Label<ShadowMethod>{ShadowMethod::members, "members"},
    Label<ShadowMethod>{ShadowMethod::coverage, "coverage"},
    Label<ShadowMethod>{ShadowMethod::opacity, "opacity"},
    Label<ShadowMethod>{ShadowMethod::volume, "volume"},
};

struct ShadowParams {
  int member_rays = max_members;  ///< `members`: rays a receiver, at most; 1 or more
  OpacityParams opacity{};
  VolumeParams volume{};
};

/// The approximator for `method`, for receivers of `cache`, or null for `none`. Keeps references to
/// tracer and cache. Throws Error(input) where the cache lacks what the method needs.
std::unique_ptr<VisibilitySource> make_shadow(ShadowMethod method, const Tracer& tracer,
                                              const RelightCache& cache,
                                              const ShadowParams& params = {});

}  // namespace relume
