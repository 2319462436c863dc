#include "viewer/frames/light_rig_usd.h"

#include <fmt/format.h>

#include <cctype>
#include <set>

namespace relume {
namespace {

/// A name that USD takes for a prim: letters, digits and '_', unique among `used`.
std::string prim_name(const std::string& name, std::set<std::string>& used) {
  std::string valid;
  for (const char c : name) {
    const auto u = static_cast<unsigned char>(c);
    valid += u < 0x80 && std::isalnum(u) != 0 ? c : '_';
  }
  if (valid.empty() || std::isdigit(static_cast<unsigned char>(valid.front())) != 0) {
    valid.insert(valid.begin(), '_');
  }
  std::string unique = valid;
  for (int i = 2; !used.insert(unique).second; ++i) unique = fmt::format("{}_{}", valid, i);
  return unique;
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

std::string format_vector(vec3 v) {
  return fmt::format("({}, {}, {})", v.x, v.y, v.z);
}

/// The rows of the matrix that takes local -z to the light's direction and the origin to its
/// position. USD's vectors are rows.
std::string format_transform(const Light& light) {
  const vec3 z = -normalize_or(light.direction, vec3(0, -1, 0));
  const vec3 helper = std::abs(z.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0);
  const vec3 x = glm::normalize(glm::cross(helper, z));
  const vec3 y = glm::cross(z, x);
  const vec3 p = light.position;
  return fmt::format("( ({}, {}, {}, 0), ({}, {}, {}, 0), ({}, {}, {}, 0), ({}, {}, {}, 1) )", x.x,
                     x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z, p.x, p.y, p.z);
}

/// What UsdLux has no attribute for, under our own names.
std::string format_own(const Light& light) {
  std::string out = fmt::format("        custom string relume:name = {}\n", quoted(light.name));
  if (!light.falloff) out += "        custom bool relume:falloff = 0\n";
  if (light.range > 0) out += fmt::format("        custom float relume:range = {}\n", light.range);
  return out;
}

std::string format_light(const Light& light, const std::string& name) {
  const bool is_distant = light.type == LightType::directional;
  const bool is_spot = light.type == LightType::spot;
  // A normalised sphere of intensity I sends I / 4 in every direction: its power, spread over a
  // surface four times its silhouette.
  const double intensity = is_distant ? light.gain : 4.0 * light.gain;
  std::string out = fmt::format(
      "    def {} \"{}\" (\n        prepend apiSchemas = [\"ShadowAPI\"{}]\n    )\n    {{\n",
      is_distant ? "DistantLight" : "SphereLight", name, is_spot ? ", \"ShapingAPI\"" : "");
  out += fmt::format("        color3f inputs:color = {}\n", format_vector(light.color));
  out += fmt::format("        float inputs:intensity = {}\n", static_cast<float>(intensity));
  out += "        bool inputs:normalize = 1\n";
  if (is_distant) {
    out += "        float inputs:angle = 0\n";
  } else {
    out += "        float inputs:radius = 0.001\n        bool treatAsPoint = 1\n";
  }
  if (is_spot) {
    out += fmt::format("        float inputs:shaping:cone:angle = {}\n", light.outer_angle_deg);
    out += fmt::format("        float inputs:shaping:cone:softness = {}\n",
                       1 - light.inner_angle_deg / light.outer_angle_deg);
  }
  out += fmt::format("        bool inputs:shadow:enable = {}\n", light.casts_shadow ? 1 : 0);
  if (light.mute) out += "        token visibility = \"invisible\"\n";
  out += format_own(light);
  out += fmt::format("        matrix4d xformOp:transform = {}\n", format_transform(light));
  return out + "        uniform token[] xformOpOrder = [\"xformOp:transform\"]\n    }\n";
}

}  // namespace

std::string format_light_rig_usd(std::span<const Light> lights) {
  std::string out =
      "#usda 1.0\n(\n    defaultPrim = \"lights\"\n    upAxis = \"Y\"\n)\n\ndef Xform "
      "\"lights\"\n{\n";
  std::set<std::string> used;
  for (const Light& light : lights) out += format_light(light, prim_name(light.name, used));
  return out + "}\n";
}

}  // namespace relume
