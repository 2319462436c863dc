#include "shadow/light_plane.h"

#include "core/math/frame.h"

namespace relume {
namespace {

constexpr float parallel_distance = 1e4f;  ///< radii
constexpr float margin_texels = 3;         ///< around what receivers ask for
constexpr int max_side = 8192;             ///< texels

/// A rectangle of x / z and y / z, or of x and y.
struct Rectangle {
  vec2 low{std::numeric_limits<float>::infinity()};
  vec2 high{-std::numeric_limits<float>::infinity()};

  bool empty() const { return !(low.x <= high.x); }
  void extend(vec2 p) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
};

vec3 corner_of(const Bounds& box, int i) {
  return {(i & 1) != 0 ? box.high.x : box.low.x, (i & 2) != 0 ? box.high.y : box.low.y,
          (i & 4) != 0 ? box.high.z : box.low.z};
}

/// Extends `seen` by what a perspective view sees of a box.
void extend_perspective(const LightPlane& view, const Bounds& box, Rectangle& seen) {
  vec3 corners[8];
  int outside[5] = {};  // corners beyond the four sides and behind
  for (int i = 0; i < 8; ++i) {
    const vec3 p = view.to_light(corner_of(box, i));
    corners[i] = p;
    outside[0] += p.x > p.z;
    outside[1] += -p.x > p.z;
    outside[2] += p.y > p.z;
    outside[3] += -p.y > p.z;
    outside[4] += p.z <= 0;
  }
  for (const int count : outside) {
    if (count == 8) return;
  }
  if (outside[4] > 0) {
    seen.extend(vec2(-1));
    seen.extend(vec2(1));
    return;
  }
  for (const vec3 p : corners) {
    seen.extend(glm::clamp(vec2(p.x, p.y) / p.z, vec2(-1), vec2(1)));
  }
}

void place_texels(const Rectangle& seen, float scale, LightPlane& view) {
  view.scale = scale;
  const vec2 size = (seen.high - seen.low) * scale + 2 * margin_texels + 1.0f;
  view.width = static_cast<int>(std::min(size.x, float{max_side}));
  view.height = static_cast<int>(std::min(size.y, float{max_side}));
  view.offset_u = margin_texels - seen.low.x * scale;
  view.offset_v = margin_texels - seen.low.y * scale;
}

/// The density at which rectangles of `area` altogether, the longest `side` long, take
/// `max_texels`.
float texel_density(double area, double side, uint64_t max_texels) {
  const double limit = (max_side - 2 * margin_texels - 1) / std::max(side, 1e-30);
  const double wanted = std::sqrt(static_cast<double>(max_texels) / std::max(area, 1e-30));
  return static_cast<float>(std::min(limit, wanted));
}

std::vector<LightPlane> make_parallel_view(vec3 direction, std::span<const Bounds> boxes,
                                           const Bounds& all, const Bounds& casters,
                                           uint64_t max_texels) {
  LightPlane view;
  view.perspective = false;
  view.origin = all.center();
  view.z = direction;
  const Frame frame = make_frame(direction);
  view.x = frame.tangent;
  view.y = frame.bitangent;
  Rectangle seen;
  for (const Bounds& box : boxes) {
    for (int i = 0; i < 8; ++i) {
      const vec3 p = view.to_light(corner_of(box, i));
      seen.extend({p.x, p.y});
    }
  }
  Bounds reach = all;
  reach.extend(casters);
  view.far = 2 * reach.radius();
  // Thin rectangles count as a hundredth of their length wide.
  const vec2 size = seen.high - seen.low;
  const float side = std::max(size.x, size.y);
  const double area = std::max(double{size.x} * size.y, 0.01 * side * side);
  place_texels(seen, texel_density(area, side, max_texels), view);
  return {view};
}

}  // namespace

std::vector<LightPlane> fit_light_planes(const Light& light, std::span<const Bounds> boxes,
                                         const Bounds& casters, uint64_t max_texels) {
  Bounds all;
  for (const Bounds& box : boxes) all.extend(box);
  if (all.empty()) return {};
  const vec3 travel = normalize_or(light.direction, vec3(0, -1, 0));
  const dvec3 offset = dvec3(all.center()) - dvec3(light.position);
  Bounds reach = all;
  reach.extend(casters);
  if (light.type == LightType::directional) {
    return make_parallel_view(travel, boxes, all, casters, max_texels);
  }
  if (glm::length(offset) > double{parallel_distance} * reach.radius()) {
    const vec3 direction = normalize_or(vec3(glm::normalize(offset)), travel);
    return make_parallel_view(direction, boxes, all, casters, max_texels);
  }
  const vec3 forward = normalize_or(vec3(offset), travel);
  const Frame frame = make_frame(forward);
  const vec3 axes[3] = {frame.tangent, frame.bitangent, forward};
  std::vector<LightPlane> views;
  std::vector<Rectangle> rectangles;
  double area = 0;
  double side = 0;
  for (int face = 0; face < 6; ++face) {
    LightPlane view;
    view.origin = light.position;
    const int axis = face % 3;
    view.x = axes[(axis + 1) % 3];
    view.y = axes[(axis + 2) % 3];
    view.z = face < 3 ? axes[axis] : -axes[axis];
    view.near = 1e-5f * reach.radius();
    Rectangle seen;
    for (const Bounds& box : boxes) {
      if (!box.empty()) extend_perspective(view, box, seen);
    }
    if (seen.empty()) continue;
    const vec2 size = seen.high - seen.low;
    const double longest = std::max(size.x, size.y);
    side = std::max(side, longest);
    area += std::max(double{size.x} * size.y, 0.01 * longest * longest);
    views.push_back(view);
    rectangles.push_back(seen);
  }
  const float density = texel_density(area, side, max_texels);
  for (size_t i = 0; i < views.size(); ++i) place_texels(rectangles[i], density, views[i]);
  return views;
}

int find_plane(std::span<const LightPlane> views, vec3 p_world) {
  for (size_t i = 0; i < views.size(); ++i) {
    if (!views[i].perspective) return static_cast<int>(i);
    const vec3 p = views[i].to_light(p_world);
    if (p.z > 0 && std::abs(p.x) <= p.z && std::abs(p.y) <= p.z) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace relume
