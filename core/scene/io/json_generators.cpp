#include <fmt/format.h>

#include "core/scene/io/json_geometry.h"
#include "core/scene/limits.h"
#include "core/scene/procedural/generators.h"

namespace relume {
namespace {

enum class Generator { hair_ball, plant_field, sphere, plane, box };

constexpr std::array generator_labels = {
    Label<Generator>{Generator::hair_ball, "hair-ball"},
    Label<Generator>{Generator::plant_field, "plant-field"},
    Label<Generator>{Generator::sphere, "sphere"},
    Label<Generator>{Generator::plane, "plane"},
    Label<Generator>{Generator::box, "box"},
};

// Sizes of generated things: small enough that a product of two stays far below max_coordinate.
constexpr float min_size = 1e-6f;
constexpr float max_size = 1e6f;

/// One generator entry.
class GeneratorReader {
 public:
  GeneratorReader(const JsonNode& node, const MaterialNames& materials,
                  const std::vector<std::string_view>& extra_keys)
      : node_(node), materials_(materials), keys_(extra_keys) {
    keys_.push_back("generator");
  }

  std::optional<Prototype> read(Scene& scene) {
    switch (node_.get("generator", "name one").label(generator_labels)) {
      case Generator::hair_ball:
        return read_hair_ball();
      case Generator::plant_field:
        read_plant_field(scene);
        return std::nullopt;
      case Generator::sphere:
        return single(read_sphere());
      case Generator::plane:
        return single(read_plane());
      case Generator::box:
        return single(read_box());
    }
    throw node_.error("has no generator", "name one");
  }

 private:
  void expect_keys(std::initializer_list<std::string_view> own) {
    keys_.insert(keys_.end(), own);
    node_.expect_keys(keys_);
  }

  static Prototype single(Mesh mesh) {
    Prototype prototype;
    prototype.shapes.emplace_back(std::move(mesh));
    return prototype;
  }

  uint32_t material(std::string_view key) const {
    return materials_.find(node_.get(key, "name one of the file's materials"));
  }

  std::vector<uint32_t> material_list(std::string_view key) const {
    const JsonNode list = node_.get(key, "list some of the file's materials");
    std::vector<uint32_t> indices;
    for (const JsonNode& item : list.items(max_materials)) indices.push_back(materials_.find(item));
    if (indices.empty()) throw list.error("is empty", "name at least one material");
    return indices;
  }

  uint32_t count(std::string_view key, uint32_t fallback, uint32_t low, uint64_t limit) const {
    const auto node = node_.find(key);
    return node ? static_cast<uint32_t>(node->count(low, limit)) : fallback;
  }

  Prototype read_hair_ball() {
    expect_keys({"strands", "segments", "ball_radius", "length", "strand_radius", "tip_scale",
                 "curl", "seed", "strand_materials", "ball_material"});
    HairBallParams params;
    params.strands = count("strands", params.strands, 1, max_strands);
    params.segments = static_cast<int>(count("segments", params.segments, 1, 256));
    const uint64_t segments = uint64_t{params.strands} * static_cast<uint64_t>(params.segments);
    if (segments > max_segments) {
      throw limit_error(node_.place(), fmt::format("{} strand segments are too many", segments),
                        fmt::format("the limit is {}", max_segments));
    }
    node_.read("ball_radius", params.ball_radius, min_size, max_size);
    if (const auto length = node_.find("length")) {
      const vec2 range = length->pair(min_size, max_size);
      if (range.x > range.y) throw length->error("runs downwards", "give [shortest, longest]");
      params.length_low = range.x;
      params.length_high = range.y;
    }
    node_.read("strand_radius", params.strand_radius, 1e-9f, max_size);
    node_.read("tip_scale", params.tip_scale, 1e-3f, 1);
    node_.read("curl", params.curl, 0, 1);
    node_.read_seed("seed", params.seed);
    params.strand_materials = material_list("strand_materials");
    params.ball_material = material("ball_material");
    return make_hair_ball(params);
  }

  void read_plant_field(Scene& scene) {
    expect_keys({"size", "plants", "grass", "hill_height", "seed", "leaf_materials",
                 "grass_materials", "flower_materials", "stem_material", "ground_material"});
    for (const std::string_view key : {"transform", "prototype", "name"}) {
      if (const auto node = node_.find(key)) {
        throw node->error("does not apply to a plant field", "remove it");
      }
    }
    PlantFieldParams params;
    node_.read("size", params.size, min_size, max_size);
    params.plants = count("plants", params.plants, 0, 1'000'000);
    params.grass = count("grass", params.grass, 0, 1'000'000);
    node_.read("hill_height", params.hill_height, 0, max_size);
    node_.read_seed("seed", params.seed);
    params.leaf_materials = material_list("leaf_materials");
    params.grass_materials = material_list("grass_materials");
    if (node_.find("flower_materials")) params.flower_materials = material_list("flower_materials");
    params.stem_material = material("stem_material");
    params.ground_material = material("ground_material");
    add_plant_field(params, scene);
  }

  Mesh read_sphere() {
    expect_keys({"center", "radius", "rings", "material"});
    SphereParams params;
    node_.read("center", params.center, -max_size, max_size);
    node_.read("radius", params.radius, min_size, max_size);
    params.rings = static_cast<int>(count("rings", params.rings, 3, 2048));
    params.material = material("material");
    return make_sphere(params);
  }

  Mesh read_plane() {
    expect_keys({"center", "half_size", "material"});
    vec3 center(0);
    node_.read("center", center, -max_size, max_size);
    const vec2 half_size = node_.get("half_size", "give [x, z]").pair(min_size, max_size);
    return make_plane(center, half_size, material("material"));
  }

  Mesh read_box() {
    expect_keys({"center", "half_size", "material"});
    vec3 center(0);
    node_.read("center", center, -max_size, max_size);
    const vec3 half_size = node_.get("half_size", "give [x, y, z]").vector(min_size, max_size);
    return make_box(center, half_size, material("material"));
  }

  const JsonNode& node_;
  const MaterialNames& materials_;
  std::vector<std::string_view> keys_;
};

}  // namespace

std::optional<Prototype> read_generator(const JsonNode& node, const MaterialNames& materials,
                                        const std::vector<std::string_view>& extra_keys,
                                        Scene& scene) {
  return GeneratorReader(node, materials, extra_keys).read(scene);
}

}  // namespace relume
