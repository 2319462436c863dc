#include "shadow/light_views.h"

namespace relume {
namespace {

/// Two unit vectors across a unit vector.
void make_axes(dvec3 forward, dvec3& right, dvec3& up) {
  const dvec3 any = std::abs(forward.x) < 0.5 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  right = glm::normalize(glm::cross(forward, any));
  up = glm::cross(right, forward);
}

/// The view along `forward` whose depths start at `origin`.
CoverageView make_view(dvec3 forward, dvec3 origin, double k) {
  dvec3 right;
  dvec3 up;
  make_axes(forward, right, up);
  CoverageView view{};
  const dvec3 rows[] = {right, up, forward};
  for (int i = 0; i < 3; ++i) {
    for (size_t axis = 0; axis < 3; ++axis) view.row[i][axis] = static_cast<float>(rows[i][axis]);
    view.row[i][3] = static_cast<float>(-glm::dot(rows[i], origin));
  }
  view.k = static_cast<float>(k);
  return view;
}

constexpr dvec3 cube_faces[max_light_views] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                               {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};

/// From this many radii on one view holds all receivers, no more than 56 degrees off its axis.
constexpr double single_view_distance = 1.2;

}  // namespace

size_t LightViews::view_of(vec3 p) const {
  if (views.size() < 2) return 0;
  const dvec3 d = dvec3(p) - position;
  const dvec3 size = glm::abs(d);
  const size_t axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  return 2 * axis + (d[axis] < 0 ? 1 : 0);
}

LightViews make_light_views(const Light& light, dvec3 center, double scale) {
  LightViews result;
  result.is_parallel = light.type == LightType::directional;
  result.to_light = -glm::normalize(dvec3(light.direction));
  if (result.is_parallel) {
    result.views.push_back(make_view(-result.to_light, dvec3(0), 0));
    return result;
  }
  if (light.type == LightType::spot) {
    result.cos_outer = std::cos(static_cast<double>(radians_from_degrees(light.outer_angle_deg)));
  }
  result.position = (dvec3(light.position) - center) / scale;
  const double distance = glm::length(result.position);
  if (distance > single_view_distance) {
    const double k = 1 / distance;
    result.views.push_back(make_view(-result.position / distance, dvec3(0), k));
    result.extent = static_cast<float>(1 / std::sqrt(1 - k * k));
    return result;
  }
  for (const dvec3& face : cube_faces) {
    result.views.push_back(make_view(face, result.position + face, 1));
  }
  return result;
}

}  // namespace relume
