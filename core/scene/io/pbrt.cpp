#include "core/scene/io/pbrt.h"

#include <fmt/format.h>

#include <cctype>

#include "core/math/transform.h"
#include "core/scene/io/imported_scene.h"
#include "core/scene/io/packed_file.h"
#include "core/scene/io/pbrt_materials.h"
#include "core/scene/io/pbrt_shapes.h"
#include "core/scene/io/pbrt_world.h"
#include "core/scene/io/shape_collector.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

mat4x3 affine(const dmat4& m) {
  mat4x3 result;
  for (int column = 0; column < 4; ++column) result[column] = vec3(m[column]);
  return result;
}

/// An object of ObjectBegin, and the prototype that it became once it was placed.
struct PbrtObject {
  ShapeCollector shapes;
  std::optional<uint32_t> prototype;
};

/// An instance in the file's axes, which the camera may mirror as late as at the file's end.
struct PbrtPlacement {
  std::string object;
  dmat4 world_from_object;
  std::string place;
};

class PbrtLoader {
 public:
  PbrtLoader(const std::filesystem::path& path, const MaterialOptions& options, Scene& scene)
      : file_(path.string()),
        folder_(path.parent_path()),
        scene_(scene),
        world_(path),
        materials_(folder_, file_, options, scene) {}

  std::vector<Instance> load() {
    while (const auto statement = world_.next()) read(*statement);
    if (object_ != nullptr) throw input_error(file_, "an ObjectBegin does not end", "end it");
    std::vector<Instance> instances = place_all();
    if (instances.empty()) throw input_error(file_, "shows no shape that is read", "check it");
    materials_.check_leaves();
    if (has_emitters_) {
      materials_.note("area lights are seen, from both sides, but light nothing else");
    }
    for (const std::string& note : world_.notes()) materials_.note(note);
    materials_.print_notes();
    return instances;
  }

 private:
  void read(const PbrtStatement& statement) {
    const std::string& name = statement.name;
    int& material = world_.state().material;
    if (name == "Shape") {
      read_shape(statement);
    } else if (name == "Texture") {
      materials_.add_texture(statement);
    } else if (name == "Material") {
      material = materials_.add(statement.words[0], "", statement.parameters);
    } else if (name == "MakeNamedMaterial") {
      materials_.add_named(statement);
    } else if (name == "NamedMaterial") {
      material = materials_.find_named(statement);
    } else if (name == "ObjectBegin") {
      if (object_ != nullptr) statement.parameters.fail("objects stand in each other", "end one");
      object_ = &objects_[statement.words[0]];
    } else if (name == "ObjectEnd") {
      object_ = nullptr;
    } else if (name == "ObjectInstance") {
      if (object_ != nullptr) statement.parameters.fail("stands in an object", "end that first");
      add_placement(statement);
    }
  }

  void read_shape(const PbrtStatement& statement) {
    const PbrtState& state = world_.state();
    const std::string& kind = statement.words[0];
    const bool is_strand = kind == "curve";
    const auto material =
        materials_.find(state.material, is_strand, alpha_of(statement), state.emission);
    if (!material) return;
    has_emitters_ |= state.emission != vec3(0);
    const std::string& place = statement.parameters.place;
    ShapeCollector& shapes = object_ != nullptr ? object_->shapes : alone_;
    const mat4x3 transform = affine(state.world_from_local);
    if (is_strand) {
      shapes.add_strand(read_pbrt_curve(statement), transform, *material, place);
    } else if (const auto mesh = read_pbrt_mesh(statement, folder_)) {
      if (kind == "loopsubdiv") materials_.note("subdivision surfaces are not subdivided");
      shapes.add(*mesh, transform, *material, place);
    } else {
      materials_.note(fmt::format("shapes of kind \"{}\" are left out", kind));
    }
  }

  static std::string alpha_of(const PbrtStatement& statement) {
    const PbrtParameter* alpha = statement.parameters.find("alpha");
    if (alpha == nullptr || alpha->type != "texture") return "";
    return statement.parameters.text("alpha", "");
  }

  void add_placement(const PbrtStatement& statement) {
    const std::string& place = statement.parameters.place;
    if (!objects_.contains(statement.words[0])) {
      statement.parameters.fail(fmt::format("there is no object \"{}\"", statement.words[0]),
                                "define it above");
    }
    if (placements_.size() >= max_instances) {
      throw limit_error(place, "too many instances", fmt::format("the limit is {}", max_instances));
    }
    placements_.push_back({statement.words[0], world_.state().world_from_local, place});
  }

  std::vector<Instance> place_all() {
    const dmat4 ours = world_.ours_from_file();
    std::vector<Instance> instances;
    if (!alone_.empty()) {
      instances.push_back({add_prototype(alone_, "world"), affine(ours)});
    }
    for (const PbrtPlacement& placement : placements_) {
      PbrtObject& object = objects_[placement.object];
      if (!object.prototype) {
        if (object.shapes.empty()) continue;
        object.prototype = add_prototype(object.shapes, placement.object);
      }
      instances.push_back({*object.prototype, affine(ours * placement.world_from_object)});
    }
    return instances;
  }

  uint32_t add_prototype(ShapeCollector& shapes, const std::string& name) {
    scene_.prototypes.push_back(shapes.take(printable(name)));
    return static_cast<uint32_t>(scene_.prototypes.size() - 1);
  }

  std::string file_;
  std::filesystem::path folder_;
  Scene& scene_;
  PbrtWorld world_;
  PbrtMaterials materials_;
  ShapeCollector alone_;
  std::map<std::string, PbrtObject> objects_;
  PbrtObject* object_ = nullptr;  ///< the one that is being defined
  std::vector<PbrtPlacement> placements_;
  bool has_emitters_ = false;  ///< shapes under an AreaLightSource
};

}  // namespace

bool is_pbrt_path(const std::filesystem::path& path) {
  std::string extension = unpacked_name(path).extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return std::tolower(c); });
  return extension == ".pbrt";
}

std::vector<Instance> load_pbrt(const std::filesystem::path& path, const MaterialOptions& options,
                                Scene& scene) {
  return PbrtLoader(path, options, scene).load();
}

std::string pbrt_scene_text(const std::filesystem::path& path) {
  PbrtWorld world(path);
  while (world.next()) {
  }
  ImportedView view{world.camera(), world.width(), world.height(), world.lights()};
  const dmat4 ours = world.ours_from_file();
  for (Light& light : view.lights) {
    light.position = vec3(ours * glm::dvec4(light.position, 1));
    light.direction = vec3(ours * glm::dvec4(light.direction, 0));
    validate_light(light, path.string());
  }
  return imported_scene_text(path, view);
}

}  // namespace relume
