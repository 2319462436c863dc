#pragma once

#include <cstdint>
#include <vector>

#include "core/scene/scene.h"

namespace relume {

// Geometry made by rule. All lengths are in the local units of the prototype the result goes into,
// y is up, material ids index Scene::materials. Every result is a pure function of its parameters
// (equal seeds, equal bytes, any thread count) and keeps the invariants of Mesh and Curves.
// Parameters are checked by the caller (the scene reader names the file and field); out-of-range
// values are CHECKs.

/// A ball covered with hair: strands rooted evenly over a sphere about the origin.
struct HairBallParams {
  uint32_t strands = 60000;       ///< [1, 10 million]
  int segments = 8;               ///< linear segments a strand, [1, 256]
  float ball_radius = 1;          ///< > 0
  float length_low = 0.25f;       ///< shortest strand, in the same units as ball_radius, > 0
  float length_high = 0.45f;      ///< longest strand, >= length_low
  float strand_radius = 0.0008f;  ///< at the root, > 0
  float tip_scale = 0.35f;        ///< radius at the tip as a fraction of the root's, (0, 1]
  float curl = 0.25f;  ///< sideways displacement as a fraction of the strand's length, [0, 1]
  uint64_t seed = 1;
  std::vector<uint32_t> strand_materials{0};  ///< drawn evenly per strand; at least one
  uint32_t ball_material = 0;                 ///< the skin sphere under the hair
};

/// The strands and the skin sphere, as one prototype (name "hair-ball").
Prototype make_hair_ball(const HairBallParams& params);

/// A square field of grass and plants of several species around the origin, on gently rolling
/// ground. Plants have natural sizes in metres (grass 0.3, trees 3) whatever the field's size. A
/// path, of shorter grass and few plants, winds along z through the middle; trees stand towards the
/// borders.
struct PlantFieldParams {
  float size = 20;           ///< side of the square, > 0
  float hill_height = 0.5f;  ///< ground within +- this of y = 0 in the field, >= 0
  uint32_t plants = 5000;    ///< plant instances, [0, 1 million]
  uint32_t grass = 20000;    ///< grass tuft instances, [0, 1 million]
  uint64_t seed = 1;
  std::vector<uint32_t> leaf_materials{0};   ///< species take them in turn; at least one
  std::vector<uint32_t> grass_materials{0};  ///< tufts mix them; at least one
  std::vector<uint32_t> flower_materials;    ///< petals take them in turn; empty = leaf_materials
  uint32_t stem_material = 0;
  uint32_t ground_material = 0;
};

/// Adds the prototypes of all species, an instance per plant and tuft and the ground to `scene`.
/// The defaults stand for >= 10 million triangles as seen by rays, a small fraction of that stored.
void add_plant_field(const PlantFieldParams& params, Scene& scene);

struct SphereParams {
  vec3 center{0};
  float radius = 1;  ///< > 0
  int rings = 128;   ///< bands from pole to pole, [3, 2048]; twice as many sectors
  uint32_t material = 0;
};

/// A closed sphere with smooth normals and (longitude, latitude) texture coordinates.
Mesh make_sphere(const SphereParams& params);

/// A horizontal rectangle facing +y: one quad (two triangles), texture coordinates [0, 1]^2.
/// `half_size` is along x and z, both > 0.
Mesh make_plane(vec3 center, vec2 half_size, uint32_t material);

/// An axis-aligned box with flat normals, 12 triangles; texture coordinates [0, 1]^2 on each face.
/// `half_size` > 0 in every component.
Mesh make_box(vec3 center, vec3 half_size, uint32_t material);

}  // namespace relume
