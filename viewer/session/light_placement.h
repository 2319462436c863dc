#pragma once

#include <array>
#include <optional>

#include "core/base/label.h"
#include "core/scene/camera.h"
#include "core/scene/light.h"
#include "core/trace/tracer.h"

namespace relume {

/// What a click on a surface puts there: the peak of the light's highlight or of its diffuse
/// reflection, a rim (light that grazes the surface from behind), or a shadow that is dragged.
enum class PlaceTool { none, highlight, diffuse, rim, shadow };

inline constexpr std::array place_tool_labels = {
    Label<PlaceTool>{PlaceTool::none, "move"},
    Label<PlaceTool>{PlaceTool::highlight, "highlight"},
    Label<PlaceTool>{PlaceTool::diffuse, "diffuse"},
    Label<PlaceTool>{PlaceTool::rim, "rim"},
    Label<PlaceTool>{PlaceTool::shadow, "shadow"},
};

/// The surface at a film position, in pixels; nothing where there is none.
std::optional<SurfacePoint> find_surface(const Tracer& tracer, const CameraRays& rays,
                                         vec2 film_px);

/// Turns the light around `surface`, at the distance that it has, until its highlight, diffuse
/// peak or rim is there as seen from `eye`; spots and directional lights then point there. On
/// strands, where whole cones of directions give a peak, the nearest of them is taken. No other
/// tool does anything.
void place_light(Light& light, PlaceTool tool, const SurfacePoint& surface, vec3 eye,
                 const Bounds& bounds);

/// What casts the shadow that a drag took hold of.
struct ShadowGrip {
  vec3 occluder{0};    ///< the first point in the shadow ray's way, world
  float distance = 0;  ///< from the receiver to the light, world; directional: not used
};

/// What lies between `surface` and the light; nothing when the light is seen.
std::optional<ShadowGrip> grab_shadow(const Tracer& tracer, const SurfacePoint& surface,
                                      const Light& light);

/// Moves the light so that the grip's shadow falls on `receiver`, as far from it as before; a spot
/// keeps pointing at the occluder.
void drag_shadow(Light& light, const ShadowGrip& grip, vec3 receiver);

}  // namespace relume
