#pragma once

#include <array>

#include "core/base/label.h"

namespace relume {

/// Shadow approximators. `none` sees every light from everywhere; `ray` traces one ray a receiver,
/// from its anchor (TR2007-600 sec. 4.2); `members` traces rays from the samples that a receiver
/// stands for; `coverage` rasterises thin geometry from the light onto the receivers' footprints;
/// `opacity` draws it into maps of what the light sees first; `volume` cuts it into cells that the
/// light is swept through; `automatic` picks one of them for each move (AutomaticVisibility).
enum class ShadowMethod { none, ray, members, coverage, opacity, volume, automatic };

inline constexpr std::array shadow_method_labels = {
    Label<ShadowMethod>{ShadowMethod::none, "none"},
    Label<ShadowMethod>{ShadowMethod::ray, "ray"},
    Label<ShadowMethod>{ShadowMethod::members, "members"},
    Label<ShadowMethod>{ShadowMethod::coverage, "coverage"},
    Label<ShadowMethod>{ShadowMethod::opacity, "opacity"},
    Label<ShadowMethod>{ShadowMethod::volume, "volume"},
    Label<ShadowMethod>{ShadowMethod::automatic, "auto"},
};

}  // namespace relume
