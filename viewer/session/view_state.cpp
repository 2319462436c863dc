#include "viewer/session/view_state.h"

#include "viewer/session/false_color.h"

namespace relume {

void display_image(const Image& image, const ViewState& view, DisplayQuality quality,
                   std::vector<uint8_t>& rgba) {
  rgba.resize(4 * image.pixel_count());
  if (view.false_color) {
    apply_false_color(image, view.display.exposure, rgba);
  } else {
    apply_display_rgba(image, view.display, rgba, quality);
  }
}

std::vector<Light> shown_lights(const ViewState& view) {
  std::vector<Light> lights = view.lights;
  if (view.solo_lights.empty()) return lights;
  size_t next = 0;
  for (size_t i = 0; i < lights.size(); ++i) {
    const bool is_solo =
        next < view.solo_lights.size() && view.solo_lights[next] == static_cast<int>(i);
    next += is_solo ? 1 : 0;
    lights[i].mute = lights[i].mute || !is_solo;
  }
  return lights;
}

bool same_light(const Light& a, const Light& b) {
  return a.name == b.name && a.type == b.type && a.position == b.position &&
         a.direction == b.direction && a.inner_angle_deg == b.inner_angle_deg &&
         a.outer_angle_deg == b.outer_angle_deg && a.falloff == b.falloff && a.range == b.range &&
         a.color == b.color && a.gain == b.gain && a.mute == b.mute &&
         a.casts_shadow == b.casts_shadow;
}

bool same_lighting(std::span<const Light> a, std::span<const Light> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Light& x, const Light& y) {
    return same_layer(x, y) && x.weight() == y.weight();
  });
}

}  // namespace relume
