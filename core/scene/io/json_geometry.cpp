#include "core/scene/io/json_geometry.h"

#include <fmt/format.h>

#include <map>

#include "core/scene/io/gltf.h"
#include "core/scene/io/hair_file.h"
#include "core/scene/io/obj.h"
#include "core/scene/io/packed_file.h"
#include "core/scene/io/pbrt.h"
#include "core/scene/io/ply_file.h"
#include "core/scene/io/scatter.h"
#include "core/scene/io/shape_collector.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

constexpr uint64_t max_entries = 65'536;

const std::vector<std::string_view> placement_keys{"name", "transform", "prototype"};

std::vector<std::string_view> with_placement_keys(std::initializer_list<std::string_view> own) {
  std::vector<std::string_view> keys(own);
  keys.insert(keys.end(), placement_keys.begin(), placement_keys.end());
  return keys;
}

mat4x3 rotation(int axis, float angle_deg) {
  const float c = std::cos(radians_from_degrees(angle_deg));
  const float s = std::sin(radians_from_degrees(angle_deg));
  const int a = (axis + 1) % 3;
  const int b = (axis + 2) % 3;
  mat4x3 m = identity_transform();
  m[a][a] = c;
  m[a][b] = s;
  m[b][a] = -s;
  m[b][b] = c;
  return m;
}

vec3 read_scale(const JsonNode& node) {
  const vec3 scale = node.is_array() ? node.vector(-1e6f, 1e6f) : vec3(node.number(-1e6f, 1e6f));
  for (int i = 0; i < 3; ++i) {
    if (std::abs(scale[i]) < 1e-6f) {
      throw node.error("is zero or nearly so", "give a scale of at least 1e-6 (negative mirrors)");
    }
  }
  return scale;
}

/// Reads the entries one after the other.
class GeometryReader {
 public:
  GeometryReader(const std::filesystem::path& folder, const MaterialNames& materials, Scene& scene)
      : folder_(folder), materials_(materials), scene_(scene) {}

  void read_entry(const JsonNode& node) {
    if (!node.is_object()) throw node.error("is not an object", "give { ... }");
    int kinds = 0;
    for (const std::string_view key : {"file", "generator", "instances_of", "scatter"}) {
      kinds += node.has(key) ? 1 : 0;
    }
    if (kinds != 1) {
      throw node.error("does not say what it is",
                       "give exactly one of: file, generator, instances_of, scatter");
    }
    if (const auto file = node.find("file")) {
      read_file(node, *file);
    } else if (const auto generator = node.find("generator")) {
      auto prototype = read_generator(node, materials_, placement_keys, scene_);
      if (prototype) place(node, std::move(*prototype), generator->text(max_name_length));
    } else if (const auto source = node.find("instances_of")) {
      read_instances(node, *source);
    } else {
      read_scatter(node);
    }
  }

 private:
  struct Entry {
    std::vector<Instance> parts;  ///< most have one, in its own space
    mat4x3 transform;  ///< the entry's own, applied after the parts', before a placement's
  };

  void read_file(const JsonNode& node, const JsonNode& file) {
    const std::filesystem::path path = read_path(file, folder_);
    const std::string extension = unpacked_name(path).extension().string();
    Prototype prototype;
    if (extension == ".obj" || extension == ".OBJ") {
      prototype.shapes.emplace_back(read_obj(node, path));
    } else if (extension == ".hair") {
      prototype.shapes.emplace_back(read_hair(node, path));
    } else if (extension == ".ply" || extension == ".PLY") {
      prototype.shapes = read_ply_shapes(node, path);
    } else if (is_gltf_path(path)) {
      place_scene(node, path, load_gltf);
      return;
    } else if (is_pbrt_path(path)) {
      place_scene(node, path, load_pbrt);
      return;
    } else {
      throw file.error(fmt::format("\"{}\" is no kind of geometry we read", extension),
                       "give an .obj, .gltf, .glb, .pbrt, .ply or .hair file");
    }
    place(node, std::move(prototype), path.stem().string());
  }

  Mesh read_obj(const JsonNode& node, const std::filesystem::path& path) {
    node.expect_keys(with_placement_keys(
        {"file", "material", "leaf_materials", "leaf_transmission", "smooth_angle_deg"}));
    ObjOptions options;
    read_material_options(node, options);
    node.read("smooth_angle_deg", options.smooth_angle_deg, 0, 180);
    return load_obj(path, options, scene_);
  }

  std::vector<std::variant<Mesh, Curves>> read_ply_shapes(const JsonNode& node,
                                                          const std::filesystem::path& path) {
    node.expect_keys(with_placement_keys({"file", "material"}));
    const uint32_t material =
        materials_.find(node.get("material", "name one of the file's materials"));
    ShapeCollector shapes;
    shapes.add(read_ply(path), identity_transform(), material, path.string());
    if (shapes.empty()) throw node.error("shows no triangle of any area", "check the file");
    return shapes.take("").shapes;
  }

  using LoadScene = std::vector<Instance> (*)(const std::filesystem::path&, const MaterialOptions&,
                                              Scene&);

  /// Places a file that is a scene of its own.
  void place_scene(const JsonNode& node, const std::filesystem::path& path, LoadScene load) {
    node.expect_keys(
        with_placement_keys({"file", "material", "leaf_materials", "leaf_transmission"}));
    MaterialOptions options;
    read_material_options(node, options);
    const size_t first = scene_.prototypes.size();
    std::vector<Instance> parts = load(path, options, scene_);
    const std::string name = entry_name(node, path.stem().string());
    if (scene_.prototypes.size() == first + 1) {
      scene_.prototypes[first].name = name;
    } else {
      for (size_t i = first; i < scene_.prototypes.size(); ++i) {
        scene_.prototypes[i].name = name + "/" + scene_.prototypes[i].name;
      }
    }
    place_parts(node, name, std::move(parts));
  }

  void read_material_options(const JsonNode& node, MaterialOptions& options) const {
    node.read("leaf_transmission", options.leaf_transmission, 0, 1);
    options.leaf_materials = read_names(node, "leaf_materials");
    if (const auto material = node.find("material")) {
      options.material_override = static_cast<int>(materials_.find(*material));
    }
  }

  static std::vector<std::string> read_names(const JsonNode& node, std::string_view key) {
    std::vector<std::string> names;
    const auto list = node.find(key);
    if (!list) return names;
    for (const JsonNode& item : list->items(max_materials)) {
      names.push_back(item.text(max_name_length));
    }
    return names;
  }

  Curves read_hair(const JsonNode& node, const std::filesystem::path& path) {
    node.expect_keys(with_placement_keys({"file", "material", "thickness_scale", "use_colors"}));
    HairOptions options;
    options.material = materials_.find(node.get("material", "name one of the file's materials"));
    node.read("thickness_scale", options.thickness_scale, 1e-6f, 1e6f);
    node.read("use_colors", options.use_colors);
    return load_hair(path, options);
  }

  /// Adds a prototype under its name and, unless it is only a prototype, one instance of it.
  void place(const JsonNode& node, Prototype prototype, const std::string& fallback_name) {
    prototype.name = entry_name(node, fallback_name);
    const auto index = static_cast<uint32_t>(scene_.prototypes.size());
    const std::string name = prototype.name;
    scene_.prototypes.push_back(std::move(prototype));
    place_parts(node, name, {{index, identity_transform()}});
  }

  std::string entry_name(const JsonNode& node, const std::string& fallback_name) const {
    const auto given = node.find("name");
    if (!given) return unused_name(fallback_name);
    std::string name = given->text(max_name_length);
    if (entries_.contains(name)) {
      throw given->error(fmt::format("\"{}\" is taken by an earlier entry", name),
                         "give each entry its own name");
    }
    return name;
  }

  void place_parts(const JsonNode& node, const std::string& name, std::vector<Instance> parts) {
    Entry entry{std::move(parts), identity_transform()};
    if (const auto transform = node.find("transform")) entry.transform = read_transform(*transform);
    bool only_prototype = false;
    node.read("prototype", only_prototype);
    if (!only_prototype) add_instance(entry, identity_transform(), node);
    entries_.emplace(name, std::move(entry));
  }

  std::string unused_name(const std::string& wish) const {
    std::string name = wish;
    for (int i = 2; entries_.contains(name); ++i) name = fmt::format("{}-{}", wish, i);
    return name;
  }

  const Entry& find_entry(const JsonNode& node) const {
    const std::string name = node.text(max_name_length);
    if (const auto found = entries_.find(name); found != entries_.end()) return found->second;
    std::string names;
    for (const auto& [known, entry] : entries_) names += (names.empty() ? "" : ", ") + known;
    throw node.error(fmt::format("\"{}\" is no earlier geometry", name),
                     names.empty() ? "define it above" : "give one of: " + names);
  }

  void add_instance(const Entry& entry, const mat4x3& placement, const JsonNode& node) {
    if (scene_.instances.size() + entry.parts.size() > max_instances) {
      throw limit_error(node.place(), "too many instances",
                        fmt::format("the limit is {}", max_instances));
    }
    const mat4x3 world_from_entry = compose(placement, entry.transform);
    for (const Instance& part : entry.parts) {
      scene_.instances.push_back(
          {part.prototype, compose(world_from_entry, part.world_from_local)});
    }
  }

  void read_instances(const JsonNode& node, const JsonNode& source) {
    node.expect_keys({"instances_of", "transforms"});
    const Entry& entry = find_entry(source);
    for (const JsonNode& item :
         node.get("transforms", "list the placements").items(max_instances)) {
      add_instance(entry, read_transform(item), node);
    }
  }

  void read_scatter(const JsonNode& node) {
    node.expect_keys(
        {"scatter", "count", "area", "scale", "rotate", "min_distance", "height", "seed"});
    std::vector<const Entry*> kinds;
    const JsonNode sources = node.get("scatter", "");
    if (sources.is_string()) {
      kinds.push_back(&find_entry(sources));
    } else {
      for (const JsonNode& item : sources.items(max_entries)) kinds.push_back(&find_entry(item));
    }
    if (kinds.empty()) throw sources.error("is empty", "name at least one earlier entry");
    ScatterParams params = read_scatter_params(node);
    params.kinds = static_cast<uint32_t>(kinds.size());
    const std::vector<Placement> placements = scatter(params);
    if (placements.size() < params.count) {
      throw node.error(fmt::format("only {} of {} fit", placements.size(), params.count),
                       "lower count or min_distance, or give a larger area");
    }
    for (const Placement& p : placements) add_instance(*kinds[p.kind], p.world_from_local, node);
  }

  static ScatterParams read_scatter_params(const JsonNode& node) {
    ScatterParams params;
    params.count = static_cast<uint32_t>(node.get("count", "say how many").count(1, max_instances));
    const JsonNode area = node.get("area", "give [[x0, z0], [x1, z1]]");
    const std::vector<JsonNode> corners = area.items(2);
    if (corners.size() != 2) throw area.error("is not two corners", "give [[x0, z0], [x1, z1]]");
    const vec2 a = corners[0].pair(-max_coordinate, max_coordinate);
    const vec2 b = corners[1].pair(-max_coordinate, max_coordinate);
    params.low = glm::min(a, b);
    params.high = glm::max(a, b);
    if (const auto scale = node.find("scale")) {
      const vec2 range =
          scale->is_number() ? vec2(scale->number(1e-6f, 1e6f)) : scale->pair(1e-6f, 1e6f);
      params.scale_low = std::min(range.x, range.y);
      params.scale_high = std::max(range.x, range.y);
    }
    node.read("rotate", params.rotate);
    node.read("min_distance", params.min_distance, 0, max_coordinate);
    node.read("height", params.height, -max_coordinate, max_coordinate);
    node.read_seed("seed", params.seed);
    return params;
  }

  const std::filesystem::path& folder_;
  const MaterialNames& materials_;
  Scene& scene_;
  std::map<std::string, Entry> entries_;
};

}  // namespace

mat4x3 read_transform(const JsonNode& node) {
  node.expect_keys({"translate", "rotate_deg", "scale"});
  vec3 translate(0);
  vec3 rotate_deg(0);
  vec3 scale(1);
  node.read("translate", translate, -max_coordinate, max_coordinate);
  node.read("rotate_deg", rotate_deg, -1e6f, 1e6f);
  if (const auto value = node.find("scale")) scale = read_scale(*value);
  mat4x3 m = identity_transform();
  for (int i = 0; i < 3; ++i) m[i][i] = scale[i];
  for (int axis = 0; axis < 3; ++axis) m = compose(rotation(axis, rotate_deg[axis]), m);
  m[3] = translate;
  return m;
}

void read_geometry(const JsonNode& list, const std::filesystem::path& folder,
                   const MaterialNames& materials, Scene& scene, const ProgressCallback& progress) {
  const std::vector<JsonNode> entries = list.items(max_entries);
  GeometryReader reader(folder, materials, scene);
  Progress report(progress, "load");
  for (size_t i = 0; i < entries.size(); ++i) {
    report.update(static_cast<double>(i), static_cast<double>(entries.size()));
    reader.read_entry(entries[i]);
  }
  report.update(1, 1);
}

}  // namespace relume
