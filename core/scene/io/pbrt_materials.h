#pragma once

#include <array>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "core/scene/io/imported_material.h"
#include "core/scene/io/pbrt_text.h"

namespace relume {

/// A colour of a pbrt scene: a constant, times a texture unless that is -1.
struct PbrtColor {
  vec3 value{1};
  int texture = -1;  ///< index into Scene::textures
};

/// A pbrt material in our terms, before it is known whether surfaces or strands have it.
struct PbrtLook {
  enum class Kind { hidden, diffuse, glossy, leaf, hair };
  std::string name;
  Kind kind = Kind::diffuse;
  PbrtColor color{vec3(0.5f)};
  PbrtColor transmit{vec3(0)};  ///< Kind::leaf
  float metallic = 0;           ///< Kind::glossy, as `ggx` has it
  float reflectance = 0.04f;
  float roughness = 0.5f;
  float exponent = 40;  ///< Kind::hair
  int mask = -1;        ///< texture of its opacity, or -1
};

/// Textures and materials of a pbrt scene, added to ours as they are asked for. Materials become
/// the nearest of our shaders, each kind with a note; so do constants, images and products of
/// textures.
class PbrtMaterials {
 public:
  PbrtMaterials(std::filesystem::path folder, const std::string& file,
                const MaterialOptions& options, Scene& scene);

  void add_texture(const PbrtStatement& statement);

  /// The material of this type; returns a number for `find`.
  int add(const std::string& type, const std::string& name, const PbrtParameters& parameters);
  /// The same for MakeNamedMaterial and NamedMaterial.
  int add_named(const PbrtStatement& statement);
  int find_named(const PbrtStatement& statement) const;

  /// The index in scene.materials of material `number` for surfaces or strands, cut out by the
  /// texture `alpha` unless that is empty, which emits `emission`; nothing where it is not to be
  /// seen.
  std::optional<uint32_t> find(int number, bool is_strand, const std::string& alpha, vec3 emission);

  /// Throws Error(input) when a leaf material of the options is none of the file's.
  void check_leaves() const;

  /// What is read differently or not at all, in words; each once.
  void note(const std::string& text) { notes_.insert(text); }
  void print_notes() const;

 private:
  PbrtLook make_look(const std::string& type, const PbrtParameters& parameters);
  PbrtLook make_glossy(const std::string& type, const PbrtParameters& parameters);
  void set_opacity(const PbrtParameters& parameters, PbrtLook& look);
  PbrtLook make_metal(const std::string& type, const PbrtParameters& parameters);
  PbrtLook make_leaf_look(const PbrtParameters& parameters, bool is_scaled);
  PbrtLook make_hair(const PbrtParameters& parameters);
  PbrtColor color(const PbrtParameters& parameters, std::string_view name, vec3 fallback);
  PbrtColor texture(const std::string& name, const PbrtParameters& parameters);
  float number(const PbrtParameters& parameters, std::string_view name, float fallback);
  float roughness(const PbrtParameters& parameters, const std::string& prefix, float fallback,
                  bool is_version_3);
  Material make_surface(const PbrtLook& look) const;
  Material make_strand(const PbrtLook& look) const;

  std::filesystem::path folder_;
  const std::string& file_;
  const MaterialOptions& options_;
  Scene& scene_;
  std::vector<PbrtLook> looks_;
  std::map<std::string, int> named_;
  std::map<std::string, PbrtColor> textures_;
  using Made = std::tuple<int, bool, std::string, std::array<float, 3>>;
  std::map<Made, uint32_t> made_;
  std::set<std::string> notes_;
};

/// A colour given as rgb, as samples of a spectrum (their mean), as a named spectrum (white) or as
/// a black body (white, times pbrt-v3's factor); nothing where it is missing or a texture.
std::optional<vec3> pbrt_color(const PbrtParameters& parameters, std::string_view name);

}  // namespace relume
