#include <gtest/gtest.h>

#include "core/shade/reference.h"
#include "core/shade/shader_list.h"
#include "core/shade/shaders.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: light and record builders

constexpr double pi_double = 3.14159265358979323846;

TEST(ShaderTable, NamesItsShadersInOrder) {
  const auto table = shader_table();
  ASSERT_EQ(table.size(), 5u);
  EXPECT_EQ(table[0]->name, "lambert");
  EXPECT_EQ(table[1]->name, "phong");
  EXPECT_EQ(table[2]->name, "kajiya-kay");
  EXPECT_EQ(table[3]->name, "leaf");
  EXPECT_EQ(table[4]->name, "ggx");
  for (const ShaderInfo* shader : table) {
    EXPECT_EQ(shader->fields[position_field].source, FieldSource::position);
    EXPECT_EQ(shader->fields[bias_field].source, FieldSource::bias);
    EXPECT_EQ(make_sample_type(*shader).offsets[bias_field], 3);
  }
}

/// A Lambert sample at the origin that faces z.
const std::vector<float> lambert_at_origin = {0, 0, 0, 1e-4f, 0, 0, 1, 0.5f, 0.25f, 1};

dvec3 shade_lambert(const Light& light, double radius = 1) {
  return reference_response(make_sample_type(Lambert::info), lambert_at_origin.data(), light,
                            {0, 0, 5}, radius);
}

TEST(Reference, LambertUnderAPointLightIsAlbedoOverPiTimesCosineOverDistanceSquared) {
  const double cosine = 2 / std::sqrt(5.0);
  const dvec3 rgb = shade_lambert(make_point_light({0, 1, 2}));
  EXPECT_NEAR(rgb.x, 0.5 / pi_double * cosine / 5, 1e-15);
  EXPECT_NEAR(rgb.y, 0.25 / pi_double * cosine / 5, 1e-15);
  EXPECT_NEAR(rgb.z, 1 / pi_double * cosine / 5, 1e-15);
  EXPECT_NEAR(shade_lambert(make_point_light({0, 1, 2}, 1, false)).z, cosine / pi_double, 1e-15);
}

TEST(Reference, GainAndColourAreNotPartOfTheResponse) {
  Light light = make_point_light({0, 1, 2}, 100);
  light.color = {0, 5, 9};
  EXPECT_EQ(shade_lambert(light), shade_lambert(make_point_light({0, 1, 2})));
}

TEST(Reference, DirectionalLightIgnoresDistanceAndLength) {
  EXPECT_NEAR(shade_lambert(make_directional_light({0, 0, -1})).z, 1 / pi_double, 1e-15);
  EXPECT_NEAR(shade_lambert(make_directional_light({0, -3e-20f, -3e-20f})).z,
              std::sqrt(0.5) / pi_double, 1e-12);
  EXPECT_EQ(shade_lambert(make_directional_light({0, 0, 1})).z, 0);
}

TEST(Reference, SpotFadesSmoothlyFromInnerToOuterCone) {
  const auto at = [](double degrees) {
    const double angle = degrees * pi_double / 180;
    const vec3 axis(static_cast<float>(std::sin(angle)), 0, static_cast<float>(-std::cos(angle)));
    return shade_lambert(make_spot_light({0, 0, 2}, axis, 20, 40)).z * pi_double * 4;
  };
  EXPECT_NEAR(at(0), 1, 1e-6);
  EXPECT_NEAR(at(19.9), 1, 1e-6);
  EXPECT_EQ(at(40.1), 0);
  EXPECT_EQ(at(180), 0);
  double last = 1;
  for (double degrees = 20.5; degrees < 40; degrees += 0.5) {
    const double t = (std::cos(degrees * pi_double / 180) - std::cos(40 * pi_double / 180)) /
                     (std::cos(20 * pi_double / 180) - std::cos(40 * pi_double / 180));
    EXPECT_NEAR(at(degrees), t * t * (3 - 2 * t), 1e-5) << degrees;
    EXPECT_LT(at(degrees), last);
    last = at(degrees);
  }
}

TEST(Reference, LightAtTheSampleStaysFinite) {
  for (const float distance : {0.0f, 1e-30f, 1e-6f, 1e-4f}) {
    const dvec3 rgb = shade_lambert(make_point_light({0, 0, distance}), 2);
    EXPECT_TRUE(std::isfinite(rgb.z)) << distance;
    // Clamped to 1e-3 of the radius: the direction shrinks with the distance.
    EXPECT_NEAR(rgb.z, distance / 2e-3 / pi_double / 4e-6, 1e-3) << distance;
  }
  EXPECT_EQ(shade_lambert(make_point_light({0, 0, 0}), 0).z, 0);
}

/// The reflected share of unit irradiance from `wi`: the integral of f cos_i over the outgoing
/// hemisphere about n (or the sphere), with cos_o as the measure of flux, by the midpoint rule.
template <class Shader>
double albedo(const std::vector<double>& v, dvec3 wi, bool cosine_out) {
  const int steps = 400;
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const double z = 2 * (i + 0.5) / steps - 1;
    for (int j = 0; j < 2 * steps; ++j) {
      const double phi = pi_double * (j + 0.5) / steps;
      const double r = std::sqrt(1 - z * z);
      const dvec3 wo(r * std::cos(phi), r * std::sin(phi), z);
      if (cosine_out && wo.z <= 0) continue;
      sum += Shader::reference(v.data(), wi, wo).x * (cosine_out ? wo.z : 1.0);
    }
  }
  return sum * 4 * pi_double / (2.0 * steps * steps);
}

TEST(Reference, LambertReflectsItsAlbedo) {
  const std::vector<double> v = {0, 0, 0, 0, 0, 0, 1, 0.7, 0.7, 0.7};
  EXPECT_NEAR(albedo<Lambert>(v, {0, 0, 1}, true), 0.7, 1e-3);
}

TEST(Reference, PhongReflectsNoMoreThanItsTwoColours) {
  for (const double exponent : {0.0, 1.0, 10.0, 40.0}) {
    const std::vector<double> v = {0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, exponent};
    for (const double angle : {0.0, 0.5, 1.2}) {
      const double reflected = albedo<Phong>(v, {std::sin(angle), 0, std::cos(angle)}, true);
      EXPECT_LE(reflected, std::cos(angle) + 1e-3) << exponent << " " << angle;
      if (angle == 0 && exponent >= 1) {
        EXPECT_NEAR(reflected, 1, 1e-2) << exponent;
      }
    }
  }
}

TEST(Reference, KajiyaKayPeaksAtTheMirrorConeAndForgetsTheTangentsSign) {
  const std::vector<double> v = {0, 0, 0, 0, 0, 0, 1, 0.3, 0.3, 0.3, 0.5, 0.5, 0.5, 50};
  std::vector<double> turned = v;
  turned[6] = -1;
  const dvec3 wi(std::sin(0.7), 0, std::cos(0.7));
  double best = 0;
  double best_angle = 0;
  for (double angle = 0; angle <= 3.14; angle += 0.01) {
    const dvec3 wo(0, std::sin(angle), std::cos(angle));
    const double value = KajiyaKay::reference(v.data(), wi, wo).x;
    EXPECT_NEAR(value, KajiyaKay::reference(turned.data(), wi, wo).x, 1e-12);
    if (value > best) {
      best = value;
      best_angle = angle;
    }
  }
  EXPECT_NEAR(best_angle, pi_double - 0.7, 0.011);
  // Along the strand there is no diffuse light.
  EXPECT_NEAR(KajiyaKay::reference(v.data(), {0, 0, 1}, {1, 0, 0}).x, 0, 1e-9);
}

TEST(Reference, LeafTransmitsWhatComesFromBehind) {
  const std::vector<double> v = {0, 0, 0, 0, 0, 0, 1, 0.4, 0.4, 0.4, 0.1, 0.2, 0.3};
  EXPECT_NEAR(Leaf::reference(v.data(), {0, 0, 1}, {0, 0, 1}).x, 0.4 / pi_double, 1e-15);
  const dvec3 behind = Leaf::reference(v.data(), {0, 0, -1}, {0, 0, 1});
  EXPECT_NEAR(behind.x, 0.1 / pi_double, 1e-15);
  EXPECT_NEAR(behind.z, 0.3 / pi_double, 1e-15);
  EXPECT_EQ(Leaf::reference(v.data(), {1, 0, 0}, {0, 0, 1}).x, 0);
}

TEST(Reference, IsNeverNegativeOrNonFinite) {
  for (const SampleType& type : all_sample_types()) {
    Random random(8, RandomStream::tests, 0);
    for (int i = 0; i < 2000; ++i) {
      std::vector<float> v;
      append_random_vector(type, random, v);
      const vec3 position = 3.0f * random_direction(random);
      const dvec3 rgb =
          reference_response(type, v.data(), make_point_light(position), {0, 0, 5}, 1);
      for (size_t c = 0; c < 3; ++c) {
        EXPECT_TRUE(std::isfinite(rgb[c]) && rgb[c] >= 0) << type.name;
      }
    }
  }
}

}  // namespace
}  // namespace relume
