#include "core/scene/io/pbrt_world.h"

#include <fmt/format.h>

#include <array>

#include "core/scene/io/pbrt_materials.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

constexpr size_t max_stack = 10'000;

dvec3 vector_at(const std::vector<double>& numbers, size_t first) {
  return {numbers[first], numbers[first + 1], numbers[first + 2]};
}

dmat4 translation(dvec3 by) {
  dmat4 m(1);
  m[3] = glm::dvec4(by, 1);
  return m;
}

dmat4 scaling(dvec3 by) {
  dmat4 m(1);
  for (int i = 0; i < 3; ++i) m[i][i] = by[static_cast<size_t>(i)];
  return m;
}

/// Throws where `v` has no direction.
dvec3 unit(dvec3 v, const PbrtParameters& parameters) {
  const double length = glm::length(v);
  if (!(length > 0 && length <= 1e30)) {
    parameters.fail("a direction is zero or too long", "mend its numbers");
  }
  return v / length;
}

/// About a unit axis (Rodrigues).
dmat4 rotation(double angle_deg, dvec3 axis) {
  const double angle = angle_deg * 3.14159265358979323846 / 180;
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  dmat4 m(1);
  for (int column = 0; column < 3; ++column) {
    dvec3 e(0);
    e[static_cast<size_t>(column)] = 1;
    m[column] = glm::dvec4(e * c + glm::cross(axis, e) * s + axis * glm::dot(axis, e) * (1 - c), 0);
  }
  return m;
}

dmat4 matrix_of(const std::vector<double>& numbers) {
  dmat4 m;
  for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = numbers[static_cast<size_t>(i)];
  return m;
}

/// pbrt's camera looks along z, with y up and x = up x z to the right.
dmat4 camera_from_world(const PbrtStatement& look_at) {
  const std::vector<double>& numbers = look_at.numbers;
  const PbrtParameters& parameters = look_at.parameters;
  const dvec3 eye = vector_at(numbers, 0);
  const dvec3 z = unit(vector_at(numbers, 3) - eye, parameters);
  const dvec3 x = unit(glm::cross(unit(vector_at(numbers, 6), parameters), z), parameters);
  dmat4 m(1);
  m[0] = glm::dvec4(x, 0);
  m[1] = glm::dvec4(glm::cross(z, x), 0);
  m[2] = glm::dvec4(z, 0);
  m[3] = glm::dvec4(eye, 1);
  return glm::inverse(m);
}

bool is_sound(const dmat4& m) {
  for (int i = 0; i < 16; ++i) {
    if (!(std::abs(m[i / 4][i % 4]) <= 1e30)) return false;
  }
  return m[0][3] == 0 && m[1][3] == 0 && m[2][3] == 0 && m[3][3] != 0;
}

vec3 point_of(const dmat4& m, vec3 p) {
  return vec3(m * glm::dvec4(p, 1));
}

}  // namespace

std::optional<PbrtStatement> PbrtWorld::next() {
  while (auto statement = reader_.next()) {
    if (!apply(*statement)) return statement;
  }
  return std::nullopt;
}

bool PbrtWorld::apply(const PbrtStatement& statement) {
  const std::string& name = statement.name;
  if (transform(statement) || attribute(statement)) return true;
  if (name == "Camera") {
    read_camera(statement);
  } else if (name == "Film") {
    read_film(statement.parameters);
  } else if (name == "LightSource") {
    read_light(statement);
  } else if (name == "AreaLightSource") {
    read_area_light(statement);
  } else if (name == "MediumInterface" || name == "MakeNamedMedium") {
    notes_.insert("media are left out");
  } else if (name == "Attribute") {
    notes_.insert("Attribute statements are left out");
  } else if (name == "WorldBegin") {
    begin_world();
  } else {
    constexpr std::array passed_over = {"Accelerator",   "ColorSpace",         "Integrator",
                                        "Option",        "PixelFilter",        "Sampler",
                                        "WorldEnd",      "ReverseOrientation", "SurfaceIntegrator",
                                        "TransformTimes"};
    return std::ranges::find(passed_over, name) != passed_over.end();
  }
  return true;
}

bool PbrtWorld::transform(const PbrtStatement& statement) {
  const std::string& name = statement.name;
  const std::vector<double>& n = statement.numbers;
  dmat4 result = state_.world_from_local;
  if (name == "Identity") {
    result = dmat4(1);
  } else if (name == "Translate") {
    result *= translation(vector_at(n, 0));
  } else if (name == "Scale") {
    result *= scaling(vector_at(n, 0));
  } else if (name == "Rotate") {
    result *= rotation(n[0], unit(vector_at(n, 1), statement.parameters));
  } else if (name == "LookAt") {
    result *= camera_from_world(statement);
  } else if (name == "Transform") {
    result = matrix_of(n);
  } else if (name == "ConcatTransform") {
    result *= matrix_of(n);
  } else if (name == "CoordSysTransform") {
    const auto found = systems_.find(statement.words[0]);
    if (found == systems_.end()) {
      statement.parameters.fail(fmt::format("there is no system \"{}\"", statement.words[0]),
                                "name it above by CoordinateSystem");
    }
    result = found->second;
  } else if (name == "CoordinateSystem") {
    systems_[statement.words[0]] = result;
  } else if (name == "ActiveTransform") {
    is_transform_active_ = statement.words[0] != "EndTime";
    notes_.insert("motion is left out: the scene stands as at its start");
  } else {
    return false;
  }
  if (!is_transform_active_) return true;
  if (!is_sound(result)) {
    statement.parameters.fail("the transform is not affine and finite", "mend its numbers");
  }
  state_.world_from_local = result / result[3][3];
  return true;
}

bool PbrtWorld::attribute(const PbrtStatement& statement) {
  const std::string& name = statement.name;
  if (name == "AttributeBegin" || name == "TransformBegin" || name == "ObjectBegin") {
    if (stack_.size() >= max_stack) {
      throw limit_error(statement.parameters.place, "attributes lie too deep",
                        fmt::format("the limit is {}", max_stack));
    }
    push();
  } else if (name == "AttributeEnd" || name == "ObjectEnd") {
    pop(statement);
  } else if (name == "TransformEnd") {
    const PbrtState before = state_;
    pop(statement);
    state_.material = before.material;
    state_.emission = before.emission;
  } else {
    return false;
  }
  return !name.starts_with("Object");
}

void PbrtWorld::pop(const PbrtStatement& statement) {
  if (stack_.empty()) {
    statement.parameters.fail(fmt::format("{} ends what has not begun", statement.name),
                              "remove it");
  }
  state_ = stack_.back();
  stack_.pop_back();
}

void PbrtWorld::begin_world() {
  state_.world_from_local = dmat4(1);
  systems_["world"] = dmat4(1);
  is_transform_active_ = true;
}

void PbrtWorld::read_camera(const PbrtStatement& statement) {
  const PbrtParameters& parameters = statement.parameters;
  const dmat4& camera_from_world = state_.world_from_local;
  const double determinant = glm::determinant(camera_from_world);
  if (!(std::abs(determinant) > 1e-30)) {
    parameters.fail("its transform is singular", "mend the transforms before it");
  }
  is_mirrored_ = determinant > 0;
  world_from_camera_ = glm::inverse(camera_from_world);
  systems_["camera"] = *world_from_camera_;
  if (statement.words[0] != "perspective") {
    notes_.insert(fmt::format("the camera \"{}\" is read as perspective", statement.words[0]));
  }
  fov_deg_ = std::clamp(parameters.number("fov", 90), 0.01, 178.0);
  if (parameters.has("halffov")) fov_deg_ = 2 * parameters.number("halffov", 45);
  for (const char* key : {"screenwindow", "lensradius"}) {
    if (parameters.has(key)) notes_.insert(fmt::format("the camera's {} is left out", key));
  }
}

void PbrtWorld::read_film(const PbrtParameters& parameters) {
  const auto side = [&](std::string_view name, int64_t fallback) {
    const int64_t pixels = parameters.integer(name, fallback);
    if (pixels >= 1 && pixels <= max_image_side) return static_cast<int>(pixels);
    throw limit_error(parameters.place, fmt::format("{} is {}", name, pixels),
                      fmt::format("give a number within [1, {}]", max_image_side));
  };
  width_ = side("xresolution", width_);
  height_ = side("yresolution", height_);
}

/// Power, intensity or radiance, times its scale; white unless given.
vec3 PbrtWorld::read_strength(const PbrtParameters& parameters, std::string_view power) {
  const auto color = pbrt_color(parameters, power).value_or(vec3(1));
  const vec3 scale = pbrt_color(parameters, "scale").value_or(vec3(1));
  if (parameters.has("power") || parameters.has("illuminance")) {
    notes_.insert("\"power\" and \"illuminance\" of lights are left out");
  }
  return glm::clamp(color * scale, vec3(0), vec3(max_emission));
}

void PbrtWorld::read_area_light(const PbrtStatement& statement) {
  const std::string& kind = statement.words[0];
  if (kind != "diffuse" && kind != "area") {
    notes_.insert(fmt::format("area lights of kind \"{}\" are left out", kind));
    state_.emission = vec3(0);
    return;
  }
  if (statement.parameters.has("filename")) notes_.insert("images of area lights are left out");
  state_.emission = read_strength(statement.parameters, "L");
}

void PbrtWorld::add_light(Light light, const PbrtParameters& parameters, std::string_view power) {
  const vec3 strength = read_strength(parameters, power);
  light.gain = std::max(max_component(strength), 0.0f);
  light.color = light.gain > 0 ? strength / light.gain : vec3(1);
  light.name = fmt::format("light-{}", lights_.size() + 1);
  if (lights_.size() >= max_lights) {
    throw limit_error(parameters.place, "too many lights",
                      fmt::format("the limit is {}", max_lights));
  }
  lights_.push_back(light);
}

void PbrtWorld::read_light(const PbrtStatement& statement) {
  const PbrtParameters& parameters = statement.parameters;
  const std::string& kind = statement.words[0];
  const dmat4& m = state_.world_from_local;
  Light light;
  const vec3 from = parameters.vector("from", vec3(0));
  const vec3 to = parameters.vector("to", vec3(0, 0, 1));
  light.position = point_of(m, from);
  light.direction = point_of(m, to) - light.position;
  if (kind == "distant") {
    light.type = LightType::directional;
    add_light(light, parameters, "L");
  } else if (kind == "spot") {
    light.type = LightType::spot;
    const double cone = parameters.number("coneangle", 30);
    const double fade = parameters.number("conedeltaangle", 5);
    light.outer_angle_deg = static_cast<float>(std::clamp(cone, double{min_spot_angle_deg}, 90.0));
    light.inner_angle_deg =
        static_cast<float>(std::clamp(cone - fade, 0.0, double{light.outer_angle_deg}));
    add_light(light, parameters, "I");
  } else if (kind == "point" || kind == "goniometric" || kind == "projection") {
    if (kind != "point")
      notes_.insert(fmt::format("lights of kind \"{}\" are read as point", kind));
    add_light(light, parameters, "I");
  } else {
    notes_.insert(fmt::format("lights of kind \"{}\" are left out", kind));
  }
}

dmat4 PbrtWorld::ours_from_file() const {
  return scaling({is_mirrored_ ? -1.0 : 1.0, 1, 1});
}

std::optional<Camera> PbrtWorld::camera() const {
  if (!world_from_camera_) return {};
  const dmat4 m = ours_from_file() * *world_from_camera_;
  Camera camera;
  camera.eye = vec3(m[3]);
  const vec3 forward = normalize_or(vec3(m[2]), vec3(0, 0, -1));
  camera.target = target_ahead(camera.eye, forward);
  camera.up = normalize_or(vec3(m[1]), vec3(0, 1, 0));
  const double half = 0.5 * fov_deg_ * 3.14159265358979323846 / 180;
  const double sides = width_ < height_ ? static_cast<double>(height_) / width_ : 1.0;
  camera.fov_y_deg = static_cast<float>(std::clamp(
      2 * std::atan(std::tan(half) * sides) * 180 / 3.14159265358979323846, 0.01, 178.0));
  return camera;
}

}  // namespace relume
