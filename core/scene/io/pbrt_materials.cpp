#include "core/scene/io/pbrt_materials.h"

#include <fmt/format.h>

#include <array>

#include "core/math/color.h"
#include "core/scene/io/alpha_mask.h"
#include "core/scene/io/texture_file.h"

namespace relume {
namespace {

using Kind = PbrtLook::Kind;

vec3 unit_color(vec3 color) {
  return glm::clamp(color, vec3(0), vec3(1));
}

/// F0 of metals, scene-linear (Lagarde, "Feeding a physically based shading model", 2011).
struct Metal {
  std::string_view name;
  vec3 color;
};
const std::array metals = {
    Metal{"Au", {1, 0.766f, 0.336f}},      Metal{"Ag", {0.972f, 0.960f, 0.915f}},
    Metal{"Al", {0.913f, 0.921f, 0.925f}}, Metal{"CuZn", {0.887f, 0.789f, 0.434f}},
    Metal{"Cu", {0.955f, 0.637f, 0.538f}},
};

/// F0 of a metal at normal incidence from its index of refraction and absorption.
vec3 metal_color(vec3 eta, vec3 k) {
  const vec3 k2 = k * k;
  return ((eta - 1.0f) * (eta - 1.0f) + k2) / ((eta + 1.0f) * (eta + 1.0f) + k2);
}

/// The root of an absorption is the logarithm of the hair's colour over this (Chiang et al., "A
/// practical and controllable hair and fur model for production path tracing", 2016, sec. 4.2).
float hair_depth(float beta) {
  const float b2 = beta * beta;
  return 5.969f - 0.215f * beta + 2.532f * b2 - 10.73f * b2 * beta + 5.574f * b2 * b2 +
         0.245f * b2 * b2 * beta;
}

/// Mean of a texture, scene-linear.
vec3 mean_of(const Texture& texture) {
  dvec3 sum(0);
  for (size_t i = 0; i < texture.texels.size(); ++i) {
    if (i % 4 == 3) continue;
    const float value = static_cast<float>(texture.texels[i]) / 255;
    sum[i % 4] += texture.srgb ? linear_from_srgb(value) : value;
  }
  return sum / std::max(1.0, static_cast<double>(texture.texels.size()) / 4);
}

}  // namespace

std::optional<vec3> pbrt_color(const PbrtParameters& parameters, std::string_view name) {
  const PbrtParameter* found = parameters.find(name);
  if (found == nullptr || found->type == "texture") return {};
  const std::vector<double>& n = found->numbers;
  if (found->type == "blackbody") return vec3(dvec3(n.size() == 2 ? n[1] : 1.0));
  if (n.empty()) return vec3(1);
  if (n.size() == 1) return vec3(dvec3(n[0]));
  if (found->type != "spectrum" && n.size() == 3) return vec3(n[0], n[1], n[2]);
  // Pairs of wavelength and value.
  double sum = 0;
  for (size_t i = 1; i < n.size(); i += 2) sum += n[i];
  return vec3(dvec3(sum / static_cast<double>(n.size() / 2)));
}

PbrtMaterials::PbrtMaterials(std::filesystem::path folder, const std::string& file,
                             const MaterialOptions& options, Scene& scene)
    : folder_(std::move(folder)), file_(file), options_(options), scene_(scene) {
  looks_.emplace_back().name = "default";
}

void PbrtMaterials::print_notes() const {
  for (const std::string& text : notes_) print_import_note(file_, text);
}

void PbrtMaterials::check_leaves() const {
  std::vector<std::string> names;
  for (const PbrtLook& look : looks_) names.push_back(look.name);
  check_leaf_materials(options_, names, file_);
}

void PbrtMaterials::add_texture(const PbrtStatement& statement) {
  const PbrtParameters& parameters = statement.parameters;
  const std::string& kind = statement.words[2];
  PbrtColor result;
  if (kind == "imagemap") {
    const std::string name = parameters.text("filename", "");
    if (name.empty()) parameters.fail("imagemap lacks its filename", "give one");
    const bool is_data = parameters.text("encoding", "sRGB") == "linear" ||
                         !parameters.flag("gamma", true) || statement.words[1] == "float";
    result.texture = relume::add_texture(scene_, pbrt_file(folder_, name, parameters.place),
                                         !is_data, parameters.place);
    result.value = unit_color(vec3(dvec3(parameters.number("scale", 1))));
    for (const char* key : {"uscale", "vscale", "udelta", "vdelta"}) {
      if (parameters.has(key)) note("the mapping of textures is left out");
    }
    if (parameters.flag("invert", false)) note("inverted textures are read as they are");
  } else if (kind == "constant") {
    result = color(parameters, "value", vec3(1));
  } else if (kind == "scale") {
    const bool is_version_4 = parameters.has("tex");
    const PbrtColor a = color(parameters, is_version_4 ? "tex" : "tex1", vec3(1));
    const PbrtColor b = color(parameters, is_version_4 ? "scale" : "tex2", vec3(1));
    if (a.texture >= 0 && b.texture >= 0) note("of a product of two images the first is read");
    result.value = unit_color(a.value * b.value);
    result.texture = a.texture >= 0 ? a.texture : b.texture;
  } else {
    note(fmt::format("textures of kind \"{}\" are read as grey", kind));
    result.value = vec3(0.5f);
  }
  textures_[statement.words[0]] = result;
}

PbrtColor PbrtMaterials::texture(const std::string& name, const PbrtParameters& parameters) {
  const auto found = textures_.find(name);
  if (found != textures_.end()) return found->second;
  parameters.fail(fmt::format("there is no texture \"{}\"", name), "define it above");
}

PbrtColor PbrtMaterials::color(const PbrtParameters& parameters, std::string_view name,
                               vec3 fallback) {
  const PbrtParameter* found = parameters.find(name);
  if (found == nullptr) return {unit_color(fallback), -1};
  if (found->type == "texture") return texture(parameters.text(name, ""), parameters);
  return {unit_color(pbrt_color(parameters, name).value_or(fallback)), -1};
}

/// A number, or the mean of a texture.
float PbrtMaterials::number(const PbrtParameters& parameters, std::string_view name,
                            float fallback) {
  const PbrtParameter* found = parameters.find(name);
  if (found == nullptr) return fallback;
  if (found->type != "texture" && found->type != "spectrum") {
    return static_cast<float>(parameters.number(name, fallback));
  }
  const PbrtColor source = color(parameters, name, vec3(fallback));
  const vec3 mean = source.texture < 0 ? vec3(1) : mean_of(scene_.textures[source.texture]);
  return source.value.x * mean.x;
}

/// Our roughness, the root of alpha. pbrt maps [0, 1] to alpha, each version by a curve of its own.
float PbrtMaterials::roughness(const PbrtParameters& parameters, const std::string& prefix,
                               float fallback, bool is_version_3) {
  const float both = number(parameters, prefix + "roughness", fallback);
  const float value = std::max(0.0f, 0.5f * (number(parameters, prefix + "uroughness", both) +
                                             number(parameters, prefix + "vroughness", both)));
  float alpha = value;
  if (parameters.flag("remaproughness", true)) {
    const float x = std::log(std::max(value, 1e-3f));
    alpha = is_version_3 ? 1.62142f + 0.819955f * x + 0.1734f * x * x + 0.0171201f * x * x * x +
                               0.000640711f * x * x * x * x
                         : std::sqrt(value);
  }
  return std::clamp(std::sqrt(std::max(alpha, 0.0f)), 0.0f, 1.0f);
}

PbrtLook PbrtMaterials::make_glossy(const std::string& type, const PbrtParameters& parameters) {
  const bool is_version_3 = type != "coateddiffuse" && type != "dielectric" && type != "disney";
  PbrtLook look;
  look.kind = Kind::glossy;
  const float grey = type == "plastic" || type == "uber" ? 0.25f : 0.5f;
  const std::string_view name = type == "disney" ? "color" : is_version_3 ? "Kd" : "reflectance";
  look.color = color(parameters, name, vec3(grey));
  look.roughness = type == "disney"
                       ? std::clamp(number(parameters, "roughness", 0.5f), 0.0f, 1.0f)
                       : roughness(parameters, "", is_version_3 ? 0.1f : 0.0f, is_version_3);
  look.metallic = std::clamp(number(parameters, "metallic", 0), 0.0f, 1.0f);
  const float eta = parameters.has("eta") && parameters.find("eta")->texts.empty()
                        ? number(parameters, "eta", 1.5f)
                        : 1.5f;
  look.reflectance = std::clamp((eta - 1) * (eta - 1) / ((eta + 1) * (eta + 1)), 0.0f, 1.0f);
  return look;
}

/// An image of opacity cuts out, one below a half hides: there is no partial transparency.
void PbrtMaterials::set_opacity(const PbrtParameters& parameters, PbrtLook& look) {
  if (!parameters.has("opacity")) return;
  const PbrtColor opacity = color(parameters, "opacity", vec3(1));
  if (opacity.texture >= 0) {
    look.mask = opacity.texture;
  } else if (luminance(opacity.value) < 0.5f) {
    look.kind = Kind::hidden;
  }
  note("opacity of materials is cut off at one half");
}

PbrtLook PbrtMaterials::make_metal(const std::string& type, const PbrtParameters& parameters) {
  PbrtLook look;
  look.kind = Kind::glossy;
  look.metallic = 1;
  const std::string prefix = type == "coatedconductor" ? "conductor." : "";
  look.roughness = roughness(parameters, prefix, type == "metal" ? 0.01f : 0.0f, type == "metal");
  if (type == "mirror") {
    look.color = color(parameters, "Kr", vec3(0.9f));
    return look;
  }
  const PbrtParameter* eta = parameters.find(prefix + "eta");
  look.color.value = metals.back().color;
  if (parameters.has("reflectance")) {
    look.color = color(parameters, "reflectance", vec3(0.5f));
  } else if (eta != nullptr && eta->texts.size() == 1) {
    for (const Metal& metal : metals) {
      if (eta->texts[0].starts_with(fmt::format("metal-{}-", metal.name))) {
        look.color.value = metal.color;
      }
    }
  } else if (eta != nullptr) {
    look.color.value =
        unit_color(metal_color(pbrt_color(parameters, prefix + "eta").value_or(vec3(1)),
                               pbrt_color(parameters, prefix + "k").value_or(vec3(1))));
  }
  return look;
}

PbrtLook PbrtMaterials::make_leaf_look(const PbrtParameters& parameters, bool is_scaled) {
  PbrtLook look;
  look.kind = Kind::leaf;
  if (!is_scaled) {
    look.color = color(parameters, "reflectance", vec3(0.25f));
    look.transmit = color(parameters, "transmittance", vec3(0.25f));
    return look;
  }
  // pbrt-v3's "translucent": one colour, of which parts are reflected and transmitted.
  look.color = color(parameters, "Kd", vec3(0.25f));
  look.transmit = look.color;
  look.color.value *= color(parameters, "reflect", vec3(0.5f)).value;
  look.transmit.value *= color(parameters, "transmit", vec3(0.5f)).value;
  return look;
}

PbrtLook PbrtMaterials::make_hair(const PbrtParameters& parameters) {
  PbrtLook look;
  look.kind = Kind::hair;
  const float beta_m = std::clamp(number(parameters, "beta_m", 0.3f), 0.01f, 1.0f);
  const float beta_n = std::clamp(number(parameters, "beta_n", 0.3f), 0.01f, 1.0f);
  // Longitudinal variance of the first lobe, ibid. sec. 4.1; sin^e falls as a Gaussian of 1 / e.
  const float width = 0.726f * beta_m + 0.812f * beta_m * beta_m + 3.7f * std::pow(beta_m, 20.0f);
  look.exponent = std::clamp(1 / (width * width), 1.0f, 1e5f);
  for (const char* name : {"reflectance", "color"}) {
    if (!parameters.has(name)) continue;
    look.color = color(parameters, name, vec3(0.5f));
    return look;
  }
  vec3 absorption = pbrt_color(parameters, "sigma_a").value_or(vec3(0));
  if (!parameters.has("sigma_a")) {
    const bool is_given = parameters.has("eumelanin") || parameters.has("pheomelanin");
    absorption =
        number(parameters, "eumelanin", is_given ? 0 : 1.3f) * vec3(0.419f, 0.697f, 1.37f) +
        number(parameters, "pheomelanin", 0) * vec3(0.187f, 0.4f, 1.05f);
  }
  look.color.value =
      unit_color(glm::exp(-glm::sqrt(glm::max(absorption, vec3(0))) * hair_depth(beta_n)));
  return look;
}

PbrtLook PbrtMaterials::make_look(const std::string& type, const PbrtParameters& parameters) {
  const auto is = [&type](std::initializer_list<std::string_view> types) {
    return std::ranges::find(types, type) != types.end();
  };
  PbrtLook look;
  if (is({"diffuse", "matte"})) {
    look.color = color(parameters, type == "matte" ? "Kd" : "reflectance", vec3(0.5f));
  } else if (is({"coateddiffuse", "plastic", "substrate", "uber", "disney"})) {
    look = make_glossy(type, parameters);
    note(fmt::format("material \"{}\" is read as ggx", type));
    set_opacity(parameters, look);
  } else if (is({"conductor", "metal", "mirror", "coatedconductor"})) {
    look = make_metal(type, parameters);
    note(fmt::format("material \"{}\" is read as ggx", type));
  } else if (is({"diffusetransmission", "translucent"})) {
    look = make_leaf_look(parameters, type == "translucent");
    note(fmt::format("material \"{}\" is read as leaf", type));
  } else if (type == "hair") {
    look = make_hair(parameters);
    note("material \"hair\" is read as kajiya-kay");
  } else if (is({"interface", "none", ""})) {
    look.kind = Kind::hidden;
  } else if (type == "mix") {
    const PbrtParameter* parts = parameters.find("materials");
    const std::string first = parts != nullptr && !parts->texts.empty()
                                  ? parts->texts[0]
                                  : parameters.text("namedmaterial1", "");
    const auto found = named_.find(first);
    if (found != named_.end()) look = looks_[found->second];
    note("of a material \"mix\" the first is read");
  } else {
    note(fmt::format("material \"{}\" is read as grey lambert", type));
  }
  return look;
}

int PbrtMaterials::add(const std::string& type, const std::string& name,
                       const PbrtParameters& parameters) {
  PbrtLook look = make_look(type, parameters);
  look.name = printable(name.empty() ? type : name);
  if (const PbrtParameter* map = parameters.find("normalmap"); map != nullptr) {
    note("normal maps are left out");
  }
  looks_.push_back(std::move(look));
  return static_cast<int>(looks_.size()) - 1;
}

int PbrtMaterials::add_named(const PbrtStatement& statement) {
  const std::string& name = statement.words[0];
  const int number = add(statement.parameters.text("type", ""), name, statement.parameters);
  named_[name] = number;
  return number;
}

int PbrtMaterials::find_named(const PbrtStatement& statement) const {
  const auto found = named_.find(statement.words[0]);
  if (found != named_.end()) return found->second;
  statement.parameters.fail(fmt::format("there is no material \"{}\"", statement.words[0]),
                            "make it above");
}

Material PbrtMaterials::make_surface(const PbrtLook& look) const {
  Material material;
  material.name = look.name;
  const vec3 value = look.color.value;
  if (is_leaf(options_, look.name)) {
    make_leaf(scene_, options_, value, look.color.texture, file_, material);
  } else if (look.kind == Kind::leaf) {
    material.shader = find_shader(scene_, "leaf", file_);
    material.parameters = {{"diffuse", value, look.color.texture},
                           {"transmit", look.transmit.value, look.transmit.texture}};
  } else if (look.kind == Kind::glossy) {
    material.shader = find_shader(scene_, "ggx", file_);
    material.parameters = {{"base_color", value, look.color.texture},
                           {"metallic", vec3(look.metallic)},
                           {"reflectance", vec3(look.reflectance)},
                           {"roughness", vec3(look.roughness)}};
  } else {
    material.shader = find_shader(scene_, "lambert", file_);
    material.parameters = {{"diffuse", value, look.color.texture}};
  }
  return material;
}

/// Textures have no place along a strand: their mean counts.
Material PbrtMaterials::make_strand(const PbrtLook& look) const {
  Material material;
  material.name = look.name;
  material.shader = find_shader(scene_, "kajiya-kay", file_);
  vec3 value = look.color.value;
  if (look.color.texture >= 0) value *= mean_of(scene_.textures[look.color.texture]);
  material.parameters = {{"diffuse", value}, {"exponent", vec3(look.exponent)}};
  if (look.kind == Kind::diffuse || look.kind == Kind::leaf) {
    material.parameters.push_back({"specular", vec3(0)});
  }
  return material;
}

std::optional<uint32_t> PbrtMaterials::find(int number, bool is_strand, const std::string& alpha,
                                            vec3 emission) {
  if (looks_[number].kind == Kind::hidden) return {};
  if (options_.material_override >= 0) return static_cast<uint32_t>(options_.material_override);
  const Made key{number, is_strand, alpha, {emission.x, emission.y, emission.z}};
  const auto [found, is_new] = made_.try_emplace(key, 0);
  if (!is_new) return found->second;
  Material material = is_strand ? make_strand(looks_[number]) : make_surface(looks_[number]);
  const auto own = textures_.find(alpha);
  const int mask = own != textures_.end() ? own->second.texture : looks_[number].mask;
  if (mask >= 0 && !is_strand) set_alpha_mask(scene_, mask, material);
  material.emission = emission;
  found->second = add_material(scene_, std::move(material), file_);
  return found->second;
}

}  // namespace relume
