#include "core/scene/procedural/plant_species.h"

#include "core/base/check.h"

namespace relume {
namespace {

constexpr vec3 up{0, 1, 0};

/// A direction between up (0) and outward (pi / 2).
vec3 leaning(vec3 outward, float angle_rad) {
  return std::cos(angle_rad) * up + std::sin(angle_rad) * outward;
}

/// A position in a disc on the ground, denser at its centre.
vec3 draw_in_disc(Random& random, float radius) {
  const vec3 outward = draw_azimuth(random);
  const float distance = random.uniform() * radius;
  return distance * outward;
}

uint32_t draw_leaf_material(const PlantMaterials& materials, float second_fraction,
                            Random& random) {
  return random.uniform() < second_fraction ? materials.second_leaf : materials.leaf;
}

/// Leaflets around the end of a stalk, as in a panicle.
void add_seed_head(MeshBuilder& builder, std::span<const Section> stalk, float length,
                   Random& random) {
  const size_t count = 14;
  for (size_t i = 0; i < count; ++i) {
    const float along = 1 - 0.35f * static_cast<float>(i) / static_cast<float>(count);
    const size_t at = static_cast<size_t>(along * static_cast<float>(stalk.size() - 1));
    const float fraction = along * static_cast<float>(stalk.size() - 1) - static_cast<float>(at);
    const vec3 next = stalk[std::min(at + 1, stalk.size() - 1)].center;
    const vec3 start = stalk[at].center + fraction * (next - stalk[at].center);
    const vec3 outward = draw_azimuth(random);
    const float angle = random.uniform(0.25f, 0.7f);
    const float size = length * random.uniform(0.7f, 1.2f);
    add_leaf(builder, trace_arc(start, leaning(outward, angle), side_of(outward), size, 0.4f, 2),
             0.12f * size, ovate_profile, 0);
  }
}

}  // namespace

vec3 draw_azimuth(Random& random) {
  const float angle = random.uniform(0, 2 * pi);
  return {std::cos(angle), 0, std::sin(angle)};
}

Mesh make_grass_tuft(const TuftShape& shape, const PlantMaterials& materials, Random& random) {
  MeshBuilder builder(materials.leaf);
  for (int i = 0; i < shape.blades; ++i) {
    builder.set_material(draw_leaf_material(materials, 0.15f, random));
    const vec3 root = draw_in_disc(random, shape.radius);
    const vec3 drift = draw_azimuth(random);
    const vec3 outward = normalize_or(root / shape.radius + 0.7f * drift, vec3(1, 0, 0));
    const float height = random.uniform(shape.height_low, shape.height_high);
    const float lean = random.uniform(0.02f, 0.45f);
    const float bend = random.uniform(0.3f, 1.7f);
    const float width = shape.half_width * random.uniform(0.7f, 1.3f);
    const bool has_seeds = random.uniform() < shape.seed_heads;
    if (!has_seeds) {
      add_leaf(builder, trace_arc(root, leaning(outward, lean), side_of(outward), height, bend, 7),
               width, blade_profile, 0);
      continue;
    }
    const std::vector<Section> stalk = trace_arc(root, leaning(outward, 0.4f * lean),
                                                 side_of(outward), 1.45f * height, 0.35f * bend, 6);
    add_tube(builder, stalk, 0.35f * width, 0.4f, 3);
    add_seed_head(builder, stalk, 0.022f, random);
  }
  return builder.take();
}

namespace {

/// Leaflets in pairs on both sides of a frond's axis, shrinking towards its tip.
void add_leaflets(MeshBuilder& builder, std::span<const Section> axis, float frond_length,
                  Random& random) {
  for (size_t i = 2; i + 1 < axis.size(); ++i) {
    const Section& s = axis[i];
    const float along = static_cast<float>(i) / static_cast<float>(axis.size() - 1);
    const float size =
        0.26f * frond_length * std::sin(pi * std::pow(along, 0.7f)) * random.uniform(0.9f, 1.1f);
    if (size < 0.01f * frond_length) continue;
    for (const float hand : {-1.0f, 1.0f}) {
      const float droop = random.uniform(0.2f, 0.7f);
      const vec3 direction = hand * 0.88f * s.side + 0.45f * s.tangent + 0.08f * s.normal;
      const vec3 unit = glm::normalize(direction);
      const vec3 leaflet_side = glm::normalize(glm::cross(unit, s.normal));
      add_leaf(builder, trace_arc(s.center, unit, leaflet_side, size, droop, 4),
               0.09f * size + 0.02f * frond_length, ovate_profile, 0.3f);
    }
  }
}

}  // namespace

Mesh make_fern(float size, const PlantMaterials& materials, Random& random) {
  MeshBuilder builder(materials.leaf);
  const uint32_t fronds = 9 + random.below(5);
  const float first_angle = random.uniform(0, 2 * pi);
  for (uint32_t i = 0; i < fronds; ++i) {
    const float jitter = random.uniform(-0.25f, 0.25f);
    const float angle =
        first_angle + 2 * pi * (static_cast<float>(i) + jitter) / static_cast<float>(fronds);
    const vec3 outward(std::cos(angle), 0, std::sin(angle));
    const float length = 0.62f * size * random.uniform(0.75f, 1.1f);
    const float lean = random.uniform(0.35f, 0.9f);
    const float bend = random.uniform(0.9f, 1.7f);
    builder.set_material(draw_leaf_material(materials, 0.1f, random));
    const std::vector<Section> axis = trace_arc(0.02f * size * outward, leaning(outward, lean),
                                                side_of(outward), length, bend, 20);
    add_tube(builder, axis, 0.007f * size, 0.15f, 3);
    add_leaflets(builder, axis, length, random);
  }
  return builder.take();
}

namespace {

/// Leaves that leave a stem at `section`, `outward` from it.
void add_stem_leaf(MeshBuilder& builder, const Section& section, vec3 outward, float length,
                   float half_width, Random& random) {
  const float lean = random.uniform(0.7f, 1.15f);
  const float bend = random.uniform(0.3f, 1.1f);
  add_leaf(builder,
           trace_arc(section.center, leaning(outward, lean), side_of(outward), length, bend, 6),
           half_width, ovate_profile, 0.28f);
}

}  // namespace

Mesh make_leafy_herb(float height, float leaf_length, const PlantMaterials& materials,
                     Random& random) {
  MeshBuilder builder(materials.leaf);
  const uint32_t stems = 4 + random.below(4);
  for (uint32_t k = 0; k < stems; ++k) {
    const vec3 outward = draw_azimuth(random);
    const float stem_length = height * random.uniform(0.65f, 1.1f);
    const float lean = random.uniform(0.03f, 0.4f);
    const float bend = random.uniform(-0.2f, 0.45f);
    const float first_turn = random.uniform(0, 2 * pi);
    builder.set_material(materials.leaf);
    const std::vector<Section> stem = trace_arc(0.06f * height * outward, leaning(outward, lean),
                                                side_of(outward), stem_length, bend, 12);
    add_tube(builder, stem, 0.009f * height, 0.3f, 4);
    for (size_t i = 1; i < stem.size(); ++i) {
      const float along = static_cast<float>(i) / static_cast<float>(stem.size() - 1);
      const float length =
          leaf_length * (1.15f - 0.7f * along * along) * random.uniform(0.8f, 1.15f);
      builder.set_material(draw_leaf_material(materials, 0.12f, random));
      for (const float half_turn : {0.0f, pi}) {
        // Pairs that cross, with some disorder.
        const float turn =
            first_turn + 1.5f * static_cast<float>(i) + half_turn + random.uniform(-0.4f, 0.4f);
        const vec3 away(std::cos(turn), 0, std::sin(turn));
        add_stem_leaf(builder, stem[i], away, length, 0.2f * length, random);
      }
    }
  }
  return builder.take();
}

namespace {

/// Petals around the upper end of a stem: `open_rad` is 0 for a closed bud and pi / 2 for a flat
/// one.
void add_petals(MeshBuilder& builder, vec3 center, uint32_t count, float length, float half_width,
                float open_rad, float bend_rad, Random& random) {
  const float first_turn = random.uniform(0, 2 * pi);
  for (uint32_t i = 0; i < count; ++i) {
    const float jitter = random.uniform(-0.15f, 0.15f);
    const float turn =
        first_turn + 2 * pi * (static_cast<float>(i) + jitter) / static_cast<float>(count);
    const vec3 outward(std::cos(turn), 0, std::sin(turn));
    const float open = open_rad + random.uniform(-0.12f, 0.12f);
    add_leaf(builder,
             trace_arc(center, leaning(outward, open), side_of(outward), length, bend_rad, 5),
             half_width, petal_profile, 0.15f);
  }
}

/// The dome in the middle of a daisy: a tube that closes at its top.
void add_disc(MeshBuilder& builder, vec3 center, float radius) {
  const std::vector<Section> axis =
      trace_arc(center - vec3(0, 0.3f * radius, 0), up, {1, 0, 0}, 0.8f * radius, 0, 3);
  add_tube(builder, axis, radius, 0, 8);
}

void add_flower_head(MeshBuilder& builder, FlowerKind kind, std::span<const Section> stem,
                     float size, const PlantMaterials& materials, Random& random) {
  const vec3 top = stem.back().center;
  builder.set_material(materials.petal);
  switch (kind) {
    case FlowerKind::daisy:
      add_petals(builder, top, 15, size, 0.15f * size, 1.35f, 0.35f, random);
      builder.set_material(materials.second_leaf);
      add_disc(builder, top + vec3(0, 0.06f * size, 0), 0.3f * size);
      return;
    case FlowerKind::cup:
      add_petals(builder, top, 6, 1.1f * size, 0.5f * size, 0.95f, -0.75f, random);
      return;
    case FlowerKind::spike:
      for (size_t i = stem.size() / 2; i < stem.size(); ++i) {
        const float along = static_cast<float>(i) / static_cast<float>(stem.size() - 1);
        add_petals(builder, stem[i].center, 6, size * (1.1f - 0.6f * along), 0.18f * size, 1.1f,
                   -0.6f, random);
      }
      return;
  }
}

}  // namespace

Mesh make_flower_group(FlowerKind kind, float height, const PlantMaterials& materials,
                       Random& random) {
  MeshBuilder builder(materials.leaf);
  const uint32_t stems = 5 + random.below(4);
  for (uint32_t k = 0; k < stems; ++k) {
    const vec3 root = draw_in_disc(random, 0.1f);
    const vec3 outward = draw_azimuth(random);
    const float length = height * random.uniform(0.65f, 1.1f);
    const float lean = random.uniform(0.0f, 0.25f);
    const float bend = random.uniform(-0.15f, 0.35f);
    const std::vector<Section> stem =
        trace_arc(root, leaning(outward, lean), side_of(outward), length, bend, 14);
    builder.set_material(materials.leaf);
    add_tube(builder, stem, 0.0022f, 0.7f, 4);
    for (size_t i = 2; i < 8; i += 2) {
      const vec3 away = draw_azimuth(random);
      add_stem_leaf(builder, stem[i], away, 0.22f * height, 0.012f, random);
    }
    const float size = 0.032f * random.uniform(0.85f, 1.2f);
    add_flower_head(builder, kind, stem, size, materials, random);
  }
  builder.set_material(materials.leaf);
  for (int i = 0; i < 14; ++i) {
    const vec3 root = draw_in_disc(random, 0.08f);
    const vec3 outward = draw_azimuth(random);
    const float lean = random.uniform(0.5f, 1.2f);
    const float length = height * random.uniform(0.25f, 0.45f);
    add_leaf(builder, trace_arc(root, leaning(outward, lean), side_of(outward), length, 0.9f, 6),
             0.016f, ovate_profile, 0.3f);
  }
  return builder.take();
}

}  // namespace relume
