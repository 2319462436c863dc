#pragma once

#include "core/base/random.h"
#include "core/scene/procedural/mesh_builder.h"

namespace relume {

// One plant each, rooted at the origin, y up, in metres. All draws come from `random`. Each returns
// a mesh of a few hundred to a few thousand triangles.

/// What a plant is made of.
struct PlantMaterials {
  uint32_t leaf = 0;
  uint32_t second_leaf = 0;  ///< a few leaves have it, for variety
  uint32_t petal = 0;
  uint32_t stem = 0;  ///< wood; green stems use `leaf`
};

/// Shape of a grass tuft.
struct TuftShape {
  int blades = 60;
  float radius = 0.09f;  ///< of the patch the blades grow from
  float height_low = 0.12f;
  float height_high = 0.32f;
  float half_width = 0.0022f;
  float seed_heads = 0;  ///< fraction of the blades that are stalks with a seed head
};
Mesh make_grass_tuft(const TuftShape& shape, const PlantMaterials& materials, Random& random);

/// A rosette of arching fronds with folded leaflets, about `size` across.
Mesh make_fern(float size, const PlantMaterials& materials, Random& random);

/// Several upright stems with alternating curved leaves.
Mesh make_leafy_herb(float height, float leaf_length, const PlantMaterials& materials,
                     Random& random);

enum class FlowerKind { daisy, cup, spike };
/// A group of flowers on thin stems over a few basal leaves.
Mesh make_flower_group(FlowerKind kind, float height, const PlantMaterials& materials,
                       Random& random);

/// A woody plant that branches `levels` times, with leaves on its last two levels.
struct WoodyShape {
  float height;
  float trunk_radius;
  int stems;  ///< from the ground
  int levels;
  int children;  ///< branches per branch
  int leaves_per_twig;
  float leaf_length;
  float spread_rad;  ///< angle between a branch and its parent
};
Mesh make_woody_plant(const WoodyShape& shape, const PlantMaterials& materials, Random& random);

/// A random horizontal unit vector.
vec3 draw_azimuth(Random& random);

/// The side vector of a part that leans towards `outward` (horizontal, unit): see trace_arc.
inline vec3 side_of(vec3 outward) {
  return {-outward.z, 0, outward.x};
}

}  // namespace relume
