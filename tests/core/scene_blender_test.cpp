#include <gtest/gtest.h>

#include "core/math/transform.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"

// The files that scenes/blender/make_example.py had Blender write.

namespace relume {
namespace {

class BlenderExample : public testing::Test {
 protected:
  const Prototype& prototype(std::string_view name) const {
    for (const Prototype& candidate : scene_.prototypes) {
      if (candidate.name == name) return candidate;
    }
    throw std::out_of_range(std::string(name));
  }
  const Curves& strands(std::string_view name) const {
    return std::get<Curves>(prototype(name).shapes.at(0));
  }

  Scene scene_ = load_scene(RELUME_SOURCE_DIR "/scenes/blender/example/ball.json", shader_table());
};

TEST_F(BlenderExample, HoldsItsMeshesStrandsLightsAndCamera) {
  EXPECT_EQ(scene_.width, 480);
  EXPECT_EQ(scene_.height, 320);
  EXPECT_EQ(strands("ball-hair").materials.size(), 150u * 3) << "three children stand for each";
  EXPECT_EQ(strands("tuft").materials.size(), 150u);
  EXPECT_EQ(count_scene(scene_).triangles, 24u * 22 + 2 + 12);
  ASSERT_EQ(scene_.lights.size(), 3u);
  EXPECT_EQ(scene_.lights[0].name, "key");
  EXPECT_NEAR(scene_.lights[0].gain, 400 / (4 * pi), 1e-3f);
  EXPECT_EQ(scene_.lights[1].name, "rim-001");
  EXPECT_EQ(scene_.lights[1].type, LightType::spot);
  EXPECT_NEAR(scene_.lights[1].outer_angle_deg, 30, 1e-3f);
  EXPECT_EQ(scene_.lights[2].type, LightType::directional);
  // Lights and camera look at the ball, whose middle stands 0.6 above the table.
  const vec3 middle(0, 0.6f, 0);
  const vec3 aim = glm::normalize(middle - scene_.lights[1].position);
  EXPECT_GT(glm::dot(aim, glm::normalize(scene_.lights[1].direction)), 0.9999f);
  const CameraRays rays(scene_.camera, scene_.width, scene_.height);
  EXPECT_LT(glm::distance(rays.project(middle).film_px, vec2(240, 160)), 0.5f);
  // A lens of 45 mm before a film of 36 mm x 24 mm.
  EXPECT_NEAR(std::tan(radians_from_degrees(scene_.camera.fov_y_deg) / 2), 12 / 45.0f, 1e-4f);
}

TEST_F(BlenderExample, HairStandsOnTheBallThatTheGlbHolds) {
  Bounds ball;
  for (const Instance& instance : scene_.instances) {
    const Prototype& placed = scene_.prototypes[instance.prototype];
    if (placed.name.find("Sphere") == std::string::npos) continue;
    ball.extend(transform_bounds(local_bounds(placed), instance.world_from_local));
  }
  ASSERT_FALSE(ball.empty());
  EXPECT_LT(glm::distance(ball.center(), vec3(0, 0.6f, 0)), 1e-4f);
  const Curves& hair = strands("ball-hair");
  for (size_t i = 0; i + 1 < hair.offsets.size(); ++i) {
    const vec4 root = hair.points[hair.offsets[i]];
    const vec4 tip = hair.points[hair.offsets[i + 1] - 1];
    const float distance = glm::distance(vec3(root), ball.center());
    EXPECT_LT(distance, 0.601f) << i;
    EXPECT_GT(distance, 0.57f) << i;
    EXPECT_GT(glm::distance(vec3(tip), ball.center()), 0.9f) << i;
    EXPECT_NEAR(root.w, 0.005f, 1e-6f) << "half a hundredth";
    EXPECT_LT(tip.w, root.w);
  }
}

TEST_F(BlenderExample, CurvesKeepTheirColours) {
  const Curves& tuft = strands("tuft");
  ASSERT_EQ(tuft.colors.size(), 150u);
  for (const vec3 color : tuft.colors) {
    EXPECT_NEAR(color.x, 0.4f * color.y, 1e-5f);
    EXPECT_GE(color.y, 0.2f);
  }
  EXPECT_NE(tuft.colors[0], tuft.colors[1]);
  EXPECT_EQ(scene_.materials.at(tuft.materials[0]).parameters.at(0).value, vec3(1));
}

}  // namespace
}  // namespace relume
