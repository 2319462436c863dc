#include "core/base/check.h"
#include "core/math/frame.h"
#include "core/scene/procedural/plant_species.h"

namespace relume {
namespace {

/// A direction at `angle_rad` from `axis`, turned by `turn_rad` about it.
vec3 branch_off(vec3 axis, float angle_rad, float turn_rad) {
  const Frame frame = make_frame(axis);
  const vec3 across = std::cos(turn_rad) * frame.tangent + std::sin(turn_rad) * frame.bitangent;
  return std::cos(angle_rad) * axis + std::sin(angle_rad) * across;
}

/// Grows one plant by recursion; every draw comes from one sequence, in order.
class WoodyGrowth {
 public:
  WoodyGrowth(const WoodyShape& shape, const PlantMaterials& materials, Random& random)
      : shape_(shape), materials_(materials), random_(random), builder_(materials.stem) {}

  Mesh grow() {
    for (int i = 0; i < shape_.stems; ++i) {
      const float turn = random_.uniform(0, 2 * pi);
      const float lean =
          shape_.stems > 1 ? random_.uniform(0.15f, 0.6f) : random_.uniform(0, 0.08f);
      const float length = shape_.height * random_.uniform(0.5f, 0.68f);
      grow_branch(vec3(0), branch_off({0, 1, 0}, lean, turn), length, shape_.trunk_radius, 1);
    }
    return builder_.take();
  }

 private:
  void grow_branch(vec3 start, vec3 direction, float length, float radius, int level) {
    const float bend_turn = random_.uniform(0, 2 * pi);
    const float bend = random_.uniform(0.1f, 0.5f);
    const Frame frame = make_frame(direction);
    const vec3 side = std::cos(bend_turn) * frame.tangent + std::sin(bend_turn) * frame.bitangent;
    const bool is_twig = level == shape_.levels;
    const std::vector<Section> axis =
        trace_arc(start, direction, side, length, bend, is_twig ? 4 : 8);
    builder_.set_material(materials_.stem);
    add_tube(builder_, axis, radius, is_twig ? 0.2f : 0.45f, level == 1 ? 8 : is_twig ? 3 : 5);
    if (is_twig) {
      add_leaves(axis, 0.1f, shape_.leaves_per_twig);
      return;
    }
    if (level + 1 == shape_.levels) add_leaves(axis, 0.5f, shape_.leaves_per_twig);
    const float first_turn = random_.uniform(0, 2 * pi);
    for (int i = 0; i < shape_.children; ++i) {
      grow_child(axis, first_turn, length, radius, level, i);
    }
  }

  void grow_child(const std::vector<Section>& axis, float first_turn, float length, float radius,
                  int level, int i) {
    // From a third of the way up, the last one carries on at the tip.
    const float order = static_cast<float>(i + 1) / static_cast<float>(shape_.children);
    const float along = 0.3f + 0.7f * order;
    const size_t at = static_cast<size_t>(along * static_cast<float>(axis.size() - 1) + 0.5f);
    const Section& section = axis[std::min(at, axis.size() - 1)];
    const float turn = first_turn + 2.4f * static_cast<float>(i) + random_.uniform(-0.3f, 0.3f);
    const float spread = shape_.spread_rad * random_.uniform(0.7f, 1.2f);
    const float angle = i + 1 == shape_.children ? 0.25f * spread : spread;
    const float child_length = length * (0.78f - 0.22f * order) * random_.uniform(0.8f, 1.15f);
    const vec3 direction = branch_off(section.tangent, angle, turn);
    // Light-seeking: a little upwards.
    const vec3 lifted = normalize_or(direction + vec3(0, 0.22f, 0), direction);
    grow_branch(section.center, lifted, child_length, radius * (0.62f - 0.2f * order), level + 1);
  }

  /// `count` leaves beyond the fraction `from` of a branch.
  void add_leaves(const std::vector<Section>& axis, float from, int count) {
    const uint32_t material = random_.uniform() < 0.15f ? materials_.second_leaf : materials_.leaf;
    builder_.set_material(material);
    const size_t last = axis.size() - 1;
    for (int i = 0; i < count; ++i) {
      const float along = random_.uniform(from, 1.0f) * static_cast<float>(last);
      const size_t at = std::min(static_cast<size_t>(along), last - 1);
      const vec3 start = axis[at].center +
                         (along - static_cast<float>(at)) * (axis[at + 1].center - axis[at].center);
      const float turn = random_.uniform(0, 2 * pi);
      const float angle = random_.uniform(0.5f, 1.2f);
      const float length = shape_.leaf_length * random_.uniform(0.7f, 1.25f);
      const float bend = random_.uniform(0.2f, 0.9f);
      const vec3 direction = branch_off(axis[at].tangent, angle, turn);
      // The blade's upper face looks up where the direction allows it.
      const vec3 side = normalize_or(glm::cross(direction, vec3(0, 1, 0)), vec3(1, 0, 0));
      add_leaf(builder_, trace_arc(start, direction, side, length, bend, 3), 0.3f * length,
               ovate_profile, 0.2f);
    }
  }

  const WoodyShape& shape_;
  const PlantMaterials& materials_;
  Random& random_;
  MeshBuilder builder_;
};

}  // namespace

Mesh make_woody_plant(const WoodyShape& shape, const PlantMaterials& materials, Random& random) {
  CHECK_MSG(shape.stems >= 1 && shape.levels >= 1 && shape.children >= 1, "stems {} levels {}",
            shape.stems, shape.levels);
  return WoodyGrowth(shape, materials, random).grow();
}

}  // namespace relume
