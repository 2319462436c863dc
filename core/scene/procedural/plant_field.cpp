#include <array>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/scene/procedural/generators.h"
#include "core/scene/procedural/mesh_builder.h"
#include "core/scene/procedural/plant_species.h"
#include "core/scene/procedural/terrain.h"

namespace relume {
namespace {

// Disjoint ranges of the scatter stream's indices.
constexpr uint64_t species_stream = uint64_t{1} << 40;
constexpr uint64_t plant_stream = uint64_t{2} << 40;
constexpr uint64_t grass_stream = uint64_t{3} << 40;

constexpr int placement_attempts = 12;

/// Where a kind of plant likes to grow.
enum class Habitat { grass, herb, shrub, tree };

struct Species {
  const char* name;
  Habitat habitat;
  float share;         ///< of all plants (or of all tufts), relative
  float cluster_size;  ///< metres
  float sink;          ///< how deep the root stands in the ground, metres
};

constexpr std::array<Species, 4> grasses{{
    {"grass-fine", Habitat::grass, 5, 1.1f, 0.01f},
    {"grass-broad", Habitat::grass, 3, 1.6f, 0.01f},
    {"grass-short", Habitat::grass, 3, 2.3f, 0.01f},
    {"grass-seeding", Habitat::grass, 1.2f, 1.9f, 0.01f},
}};

constexpr std::array<Species, 13> plants{{
    {"fern-large", Habitat::herb, 6, 1.8f, 0.01f},
    {"fern-small", Habitat::herb, 8, 1.4f, 0.01f},
    {"herb-tall", Habitat::herb, 8, 1.6f, 0.02f},
    {"herb-broad", Habitat::herb, 10, 1.3f, 0.02f},
    {"herb-low", Habitat::herb, 14, 1.0f, 0.01f},
    {"flower-daisy", Habitat::herb, 16, 1.5f, 0.01f},
    {"flower-cup", Habitat::herb, 13, 1.3f, 0.01f},
    {"flower-spike", Habitat::herb, 12, 1.2f, 0.01f},
    {"flower-daisy-tall", Habitat::herb, 8, 1.7f, 0.01f},
    {"shrub-round", Habitat::shrub, 1.7f, 2.5f, 0.03f},
    {"shrub-open", Habitat::shrub, 1.3f, 2.5f, 0.03f},
    {"tree-broad", Habitat::tree, 0.5f, 3.5f, 0.05f},
    {"tree-slender", Habitat::tree, 0.5f, 3.0f, 0.05f},
}};

uint32_t in_turn(const std::vector<uint32_t>& materials, size_t index) {
  return materials[index % materials.size()];
}

PlantMaterials materials_of(const PlantFieldParams& params, const std::vector<uint32_t>& leaves,
                            size_t species) {
  const std::vector<uint32_t>& petals =
      params.flower_materials.empty() ? params.leaf_materials : params.flower_materials;
  return {in_turn(leaves, species), in_turn(leaves, species + 1), in_turn(petals, species),
          params.stem_material};
}

Mesh make_grass(size_t species, const PlantMaterials& materials, Random& random) {
  switch (species) {
    case 0:
      return make_grass_tuft({70, 0.10f, 0.12f, 0.34f, 0.0020f, 0}, materials, random);
    case 1:
      return make_grass_tuft({46, 0.09f, 0.14f, 0.38f, 0.0038f, 0}, materials, random);
    case 2:
      return make_grass_tuft({80, 0.13f, 0.05f, 0.14f, 0.0022f, 0}, materials, random);
    default:
      return make_grass_tuft({50, 0.09f, 0.22f, 0.48f, 0.0022f, 0.3f}, materials, random);
  }
}

Mesh make_plant(size_t species, const PlantMaterials& materials, Random& random) {
  switch (species) {
    case 0:
      return make_fern(1.0f, materials, random);
    case 1:
      return make_fern(0.6f, materials, random);
    case 2:
      return make_leafy_herb(0.62f, 0.13f, materials, random);
    case 3:
      return make_leafy_herb(0.42f, 0.18f, materials, random);
    case 4:
      return make_leafy_herb(0.22f, 0.075f, materials, random);
    case 5:
      return make_flower_group(FlowerKind::daisy, 0.36f, materials, random);
    case 6:
      return make_flower_group(FlowerKind::cup, 0.42f, materials, random);
    case 7:
      return make_flower_group(FlowerKind::spike, 0.55f, materials, random);
    case 8:
      return make_flower_group(FlowerKind::daisy, 0.58f, materials, random);
    case 9:
      return make_woody_plant({1.1f, 0.014f, 6, 3, 6, 18, 0.055f, 0.75f}, materials, random);
    case 10:
      return make_woody_plant({1.4f, 0.016f, 4, 3, 6, 20, 0.07f, 0.6f}, materials, random);
    case 11:
      return make_woody_plant({3.0f, 0.07f, 1, 4, 6, 24, 0.1f, 0.85f}, materials, random);
    default:
      return make_woody_plant({3.6f, 0.05f, 1, 4, 6, 24, 0.09f, 0.6f}, materials, random);
  }
}

/// How much a habitat suits a place, in [0, 1].
float suitability(Habitat habitat, const Terrain& terrain, vec2 place) {
  const float from_path = terrain.distance_from_path(place);
  const float from_center = 2 * std::max(std::abs(place.x), std::abs(place.y)) / terrain.size();
  switch (habitat) {
    case Habitat::grass:
      return from_path < 1 ? 0.55f : 1.0f;
    case Habitat::herb:
      return std::clamp(0.7f * (from_path - 0.9f), 0.0f, 1.0f);
    case Habitat::shrub:
      return std::clamp(0.6f * (from_path - 3.2f), 0.0f, 1.0f) * (0.25f + 0.75f * from_center);
    case Habitat::tree:
      return std::clamp(0.5f * (from_path - 4.5f), 0.0f, 1.0f) *
             (from_center > 0.55f ? 1.0f : 0.05f);
  }
  return 0;
}

float draw_scale(Habitat habitat, const Terrain& terrain, vec2 place, Random& random) {
  const float scale = random.uniform(0.7f, 1.3f);
  if (habitat != Habitat::grass) return scale;
  // Trodden grass on the path is short, and grows with the distance from it.
  return scale * std::clamp(0.25f + 0.5f * terrain.distance_from_path(place), 0.35f, 1.0f);
}

/// Upright along a mix of the vertical and the ground's normal, turned about it and scaled.
mat4x3 make_placement(vec3 root, vec3 ground_normal, float lean_x, float lean_z, float turn,
                      float scale) {
  const vec3 up = glm::normalize(0.5f * ground_normal + vec3(lean_x, 0.5f, lean_z));
  const vec3 heading(std::cos(turn), 0, std::sin(turn));
  const vec3 right = glm::normalize(heading - up * glm::dot(heading, up));
  const vec3 front = glm::cross(right, up);
  return {scale * right, scale * up, scale * front, root};
}

/// Draws a species and a place that suits it, from the sequence of one instance.
template <size_t n>
Instance place_instance(const PlantFieldParams& params, const std::array<Species, n>& all,
                        const Terrain& terrain, uint32_t first_prototype, uint64_t stream_index) {
  Random random(params.seed, RandomStream::scatter, stream_index);
  float total = 0;
  for (const Species& species : all) total += species.share;
  float remaining = random.uniform(0, total);
  size_t chosen = 0;
  while (chosen + 1 < n && remaining >= all[chosen].share) remaining -= all[chosen++].share;
  const Species& species = all[chosen];

  vec2 place(0);
  float best = -std::numeric_limits<float>::infinity();
  for (int attempt = 0; attempt < placement_attempts && best < 0; ++attempt) {
    const float x = params.size * (random.uniform() - 0.5f);
    const float z = params.size * (random.uniform() - 0.5f);
    const float threshold = random.uniform();
    const vec2 candidate(x, z);
    const uint32_t pattern = first_prototype + static_cast<uint32_t>(chosen);
    const float cluster = terrain.noise(candidate / species.cluster_size, 16 + pattern);
    const float density = suitability(species.habitat, terrain, candidate) *
                          std::clamp(2.6f * cluster - 0.8f, 0.04f, 1.0f);
    if (density - threshold > best) {
      best = density - threshold;
      place = candidate;
    }
  }
  const float turn = random.uniform(0, 2 * pi);
  const float lean_x = random.uniform(-0.06f, 0.06f);
  const float lean_z = random.uniform(-0.06f, 0.06f);
  const float scale = draw_scale(species.habitat, terrain, place, random);
  const vec3 root(place.x, terrain.height(place) - species.sink * scale, place.y);
  return {first_prototype + static_cast<uint32_t>(chosen),
          make_placement(root, terrain.normal(place), lean_x, lean_z, turn, scale)};
}

void add_prototypes(const PlantFieldParams& params, Scene& scene) {
  for (size_t i = 0; i < grasses.size(); ++i) {
    Random random(params.seed, RandomStream::scatter, species_stream + i);
    const PlantMaterials materials = materials_of(params, params.grass_materials, i);
    scene.prototypes.push_back({grasses[i].name, {make_grass(i, materials, random)}});
  }
  for (size_t i = 0; i < plants.size(); ++i) {
    Random random(params.seed, RandomStream::scatter, species_stream + grasses.size() + i);
    const PlantMaterials materials = materials_of(params, params.leaf_materials, i);
    scene.prototypes.push_back({plants[i].name, {make_plant(i, materials, random)}});
  }
}

void check_params(const PlantFieldParams& params) {
  CHECK_MSG(params.size > 0 && is_finite(params.size), "size {}", params.size);
  CHECK_MSG(params.hill_height >= 0 && is_finite(params.hill_height), "hill height {}",
            params.hill_height);
  CHECK_MSG(params.plants <= 1'000'000 && params.grass <= 1'000'000, "{} plants, {} tufts",
            params.plants, params.grass);
  CHECK(!params.leaf_materials.empty() && !params.grass_materials.empty());
}

}  // namespace

void add_plant_field(const PlantFieldParams& params, Scene& scene) {
  check_params(params);
  const Terrain terrain(params.size, params.hill_height, params.seed);
  const auto ground = static_cast<uint32_t>(scene.prototypes.size());
  scene.prototypes.push_back({"ground", {terrain.make_mesh(params.ground_material)}});
  scene.instances.push_back({ground, identity_transform()});

  add_prototypes(params, scene);
  const uint32_t first_grass = ground + 1;
  const uint32_t first_plant = first_grass + static_cast<uint32_t>(grasses.size());
  const size_t first = scene.instances.size();
  scene.instances.resize(first + params.grass + params.plants);
  parallel_for(params.grass, 256, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      scene.instances[first + i] =
          place_instance(params, grasses, terrain, first_grass, grass_stream + i);
    }
  });
  parallel_for(params.plants, 256, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      scene.instances[first + params.grass + i] =
          place_instance(params, plants, terrain, first_plant, plant_stream + i);
    }
  });
}

}  // namespace relume
