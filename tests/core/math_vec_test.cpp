#include <gtest/gtest.h>

#include "core/math/color.h"
#include "core/math/frame.h"
#include "core/math/transform.h"
#include "core/math/vec.h"
#include "tests/support/records.h"

namespace relume {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

TEST(NormalizeOr, HasUnitLengthForAnyFiniteVector) {
  for (const float scale : {1e-45f, 1e-38f, 1e-20f, 1.0f, 1e20f, 3e38f}) {
    const vec3 n = normalize_or(vec3(scale, 0, -scale), vec3(0));
    EXPECT_NEAR(glm::length(n), 1, 1e-6) << scale;
    EXPECT_NEAR(n.x, std::sqrt(0.5f), 1e-6) << scale;
  }
}

TEST(NormalizeOr, FallsBackForZeroAndNonFinite) {
  const vec3 fallback(0, 1, 0);
  EXPECT_EQ(normalize_or(vec3(0), fallback), fallback);
  EXPECT_EQ(normalize_or(vec3(infinity, 0, 0), fallback), fallback);
  EXPECT_EQ(normalize_or(vec3(0, std::nanf(""), 0), fallback), fallback);
}

TEST(Bounds, EmptyUntilExtended) {
  Bounds bounds;
  EXPECT_TRUE(bounds.empty());
  EXPECT_EQ(bounds.radius(), 0);
  EXPECT_EQ(bounds.center(), vec3(0));
  bounds.extend(Bounds());
  EXPECT_TRUE(bounds.empty());
  bounds.extend(vec3(1, 2, 3));
  EXPECT_FALSE(bounds.empty());
  EXPECT_EQ(bounds.radius(), 0);
  bounds.extend(vec3(3, 2, 3));
  EXPECT_EQ(bounds.radius(), 1);
  EXPECT_EQ(bounds.center(), vec3(2, 2, 3));
}

TEST(Frame, IsOrthonormalAndRightHanded) {
  Random random(1, RandomStream::tests, 0);
  for (int i = 0; i < 1000; ++i) {
    vec3 n = test::random_direction(random);
    if (i == 0) n = {0, 0, 1};
    if (i == 1) n = {0, 0, -1};
    if (i == 2) n = {0, 1, 0};
    const Frame frame = make_frame(n);
    EXPECT_NEAR(glm::length(frame.tangent), 1, 2e-6);
    EXPECT_NEAR(glm::length(frame.bitangent), 1, 2e-6);
    EXPECT_NEAR(glm::dot(frame.tangent, n), 0, 2e-6);
    EXPECT_NEAR(glm::dot(frame.bitangent, n), 0, 2e-6);
    EXPECT_NEAR(glm::dot(glm::cross(frame.tangent, frame.bitangent), n), 1, 2e-6);
  }
}

mat4x3 random_transform(Random& random) {
  mat4x3 m;
  for (size_t column = 0; column < 4; ++column) {
    for (size_t row = 0; row < 3; ++row) m[column][row] = random.uniform(-2, 2);
  }
  return m;
}

TEST(Transform, NormalsStayPerpendicularToTheirSurface) {
  Random random(2, RandomStream::tests, 0);
  for (int i = 0; i < 200; ++i) {
    const mat4x3 m = random_transform(random);
    const vec3 u = test::random_direction(random);
    const vec3 v = test::random_direction(random);
    const vec3 n = transform_normal(m, glm::cross(u, v));
    const vec3 world_u = transform_vector(m, u);
    EXPECT_NEAR(glm::dot(n, world_u), 0, 1e-4f * (1 + glm::length(n) * glm::length(world_u)));
    // A normal stays on its side of the surface, also under a mirror transform.
    const vec3 off = transform_vector(m, glm::cross(u, v));
    EXPECT_GE(glm::dot(n, off), -1e-4f);
  }
}

TEST(Transform, ComposeAppliesTheSecondFirst) {
  Random random(3, RandomStream::tests, 0);
  const mat4x3 a = random_transform(random);
  const mat4x3 b = random_transform(random);
  const vec3 p(0.3f, -0.7f, 0.2f);
  const vec3 once = transform_point(compose(a, b), p);
  const vec3 twice = transform_point(a, transform_point(b, p));
  for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(once[i], twice[i], 1e-5);
}

TEST(Transform, UniformScaleIsTheCubeRootOfTheVolume) {
  EXPECT_FLOAT_EQ(uniform_scale(mat4x3(vec3(2, 0, 0), vec3(0, -2, 0), vec3(0, 0, 2), vec3(5))), 2);
  EXPECT_FLOAT_EQ(uniform_scale(mat4x3(vec3(8, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), vec3(0))), 2);
}

TEST(Color, SrgbRoundTripsEveryCode) {
  for (int code = 0; code < 256; ++code) {
    const float encoded = static_cast<float>(code) / 255.0f;
    EXPECT_NEAR(srgb_from_linear(linear_from_srgb(encoded)), encoded, 1e-5) << code;
  }
  EXPECT_NEAR(linear_from_srgb(0.5f), 0.21404114f, 1e-6);
  EXPECT_NEAR(luminance(vec3(1)), 1, 1e-6);
}

}  // namespace
}  // namespace relume
