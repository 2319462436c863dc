#include <gtest/gtest.h>

#include "core/samples/sample_scene.h"
#include "core/shade/ggx.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: scene builders

constexpr double pi_double = 3.14159265358979323846;

/// A sample vector at the origin that faces z.
std::vector<double> make_vector(double diffuse, double specular, double reflectance,
                                double roughness) {
  return {0,       0,       0,        0,        0,        0,           1,        diffuse,
          diffuse, diffuse, specular, specular, specular, reflectance, roughness};
}

dvec3 direction(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

/// glTF 2.0, appendix B.2 and B.3, term by term as the text has them: metallic mixes a metal and a
/// dielectric, f * cos.
dvec3 gltf_response(dvec3 base, double metallic, double roughness, dvec3 l, dvec3 v) {
  const dvec3 n(0, 0, 1);
  const dvec3 h = glm::normalize(l + v);
  const double alpha = roughness * roughness;
  const double a2 = alpha * alpha;
  const double n_h = glm::dot(n, h);
  const double d = a2 / (pi_double * std::pow(n_h * n_h * (a2 - 1) + 1, 2));
  const auto g1 = [&](double c) { return 2 * c / (c + std::sqrt(a2 + (1 - a2) * c * c)); };
  const double specular_brdf = g1(l.z) * g1(v.z) * d / (4 * l.z * v.z);
  const double schlick = std::pow(1 - std::abs(glm::dot(v, h)), 5);
  const dvec3 metal = specular_brdf * (base + (1.0 - base) * schlick);
  const double fresnel = 0.04 + (1 - 0.04) * schlick;
  const dvec3 dielectric = glm::mix(base / pi_double, dvec3(specular_brdf), fresnel);
  return glm::mix(dielectric, metal, metallic) * l.z;
}

std::vector<double> vector_of(vec3 base, float metallic, float roughness) {
  const vec3 parameters[] = {base, vec3(metallic), vec3(0.04f), vec3(roughness)};
  vec3 fields[4];
  Ggx::fields_of_parameters(parameters, fields);
  std::vector<double> v = {0, 0, 0, 0, 0, 0, 1};
  for (int i = 0; i < 2; ++i) v.insert(v.end(), {fields[i].x, fields[i].y, fields[i].z});
  v.insert(v.end(), {fields[2].x, fields[3].x});
  return v;
}

TEST(Ggx, IsTheModelOfGltfWhereItsReflectanceIsGrey) {
  Random random(1, RandomStream::tests, 0);
  for (int i = 0; i < 1000; ++i) {
    const dvec3 l = direction(1.5 * random.uniform(), 6 * random.uniform());
    const dvec3 v = direction(1.5 * random.uniform(), 6 * random.uniform());
    const float roughness = random.uniform(0.05f, 1);
    const vec3 color(random.uniform(), 0.5f, random.uniform());
    const vec3 grey(random.uniform());
    for (const auto& [base, metallic] :
         {std::pair(color, 0.0f), {grey, 1.0f}, {grey, 0.5f}, {grey, 0.1f}}) {
      const dvec3 ours = Ggx::reference(vector_of(base, metallic, roughness).data(), l, v);
      const dvec3 theirs = gltf_response(dvec3(base), metallic, roughness, l, v);
      for (size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(ours[c], theirs[c], 1e-6 * (1 + theirs[c])) << metallic << " " << roughness;
      }
    }
  }
}

TEST(Ggx, OfAColouredMetalHasItsHueAndGltfsBrightestChannel) {
  const vec3 gold(1, 0.77f, 0.34f);
  for (const double angle : {0.1, 0.7, 1.3, 1.5}) {
    const dvec3 l = direction(angle, 0);
    const dvec3 v = direction(angle, pi_double);
    const dvec3 ours = Ggx::reference(vector_of(gold, 1, 0.3f).data(), l, v);
    const dvec3 theirs = gltf_response(dvec3(gold), 1, 0.3f, l, v);
    EXPECT_NEAR(ours.x, theirs.x, 1e-6 * theirs.x);
    EXPECT_NEAR(ours.z / ours.x, 0.34, 1e-6);
    if (angle < 0.8) {
      EXPECT_NEAR(ours.z, theirs.z, 0.01 * theirs.z);
    }
  }
}

TEST(Ggx, IsReciprocal) {
  Random random(2, RandomStream::tests, 0);
  for (int i = 0; i < 1000; ++i) {
    const std::vector<double> v =
        make_vector(0.5, 0.8, random.uniform(), std::max(0.02f, random.uniform()));
    const dvec3 a = direction(1.55 * random.uniform(), 6 * random.uniform());
    const dvec3 b = direction(1.55 * random.uniform(), 6 * random.uniform());
    const double forth = Ggx::reference(v.data(), a, b).x * b.z;
    const double back = Ggx::reference(v.data(), b, a).x * a.z;
    EXPECT_NEAR(forth, back, 1e-9 * forth);
  }
}

/// The reflected share of light from `wi`: the integral of f cos over the hemisphere, by the
/// midpoint rule in theta and phi.
double albedo(const std::vector<double>& v, dvec3 wi) {
  const int steps = 400;
  const double width = 0.5 * pi_double / steps;
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const double theta = (i + 0.5) * width;
    for (int j = 0; j < steps; ++j) {
      const dvec3 wo = direction(theta, 2 * pi_double * (j + 0.5) / steps);
      sum += Ggx::reference(v.data(), wi, wo).x * wo.z * std::sin(theta);
    }
  }
  return sum * width * 2 * pi_double / steps / wi.z;
}

/// A furnace: what comes in evenly from all sides is not exceeded by what goes out.
TEST(Ggx, NeitherLobeReflectsMoreThanArrives) {
  for (const double roughness : {0.15, 0.3, 0.6, 1.0}) {
    for (const double angle : {0.0, 0.8, 1.2, 1.5}) {
      const dvec3 wi = direction(angle, 0);
      EXPECT_LE(albedo(make_vector(0, 1, 1, roughness), wi), 1.002) << roughness << " " << angle;
      EXPECT_LE(albedo(make_vector(1, 0, 0.04, roughness), wi), 1.002) << roughness << " " << angle;
    }
  }
  EXPECT_NEAR(albedo(make_vector(0, 1, 1, 0.15), {0, 0, 1}), 1, 0.01);
  EXPECT_NEAR(albedo(make_vector(0, 1, 0.04, 0.15), {0, 0, 1}), 0.04, 0.001);
}

/// Both together, white on white: glTF's diffuse part does not see what the layer above it reflects
/// at grazing angles, and neither does ours.
TEST(Ggx, AWhiteDielectricReflectsNoMoreThanArrivesUpToFortyFiveDegrees) {
  const std::vector<double> white = vector_of(vec3(1), 0, 0.5f);
  for (const double degrees : {0.0, 25.0, 45.0}) {
    const double reflected = albedo(white, direction(degrees * pi_double / 180, 0));
    EXPECT_LE(reflected, 1.0) << degrees;
    EXPECT_GT(reflected, 0.9) << degrees;
  }
}

TEST(Ggx, MeansOfSamplesReflectNoMoreThanArrives) {
  const std::vector<double> plastic = vector_of(vec3(0.5f), 0, 0.2f);
  const std::vector<double> gold = vector_of({1, 0.77f, 0.34f}, 1, 0.6f);
  std::vector<double> mean(15);
  for (size_t i = 0; i < mean.size(); ++i) mean[i] = 0.5 * plastic[i] + 0.5 * gold[i];
  for (const double angle : {0.0, 1.2, 1.5}) {
    EXPECT_LE(albedo(mean, direction(angle, 0)), 1) << angle;
  }
}

/// A ggx quad that fills the view.
Scene make_textured_scene() {
  Scene scene = make_empty_scene(make_camera({0, 0, 5}, vec3(0), 20), 16, 16);
  const uint32_t material = add_material(scene, "ggx");
  Mesh quad = make_quad(vec3(0), {50, 0, 0}, {0, 50, 0}, material);
  add_shape(scene, std::move(quad));
  // Red 51, green 102, blue 255: 0.2, 0.4, 1.
  scene.textures.push_back({"surface", 1, 1, false, {51, 102, 255, 255}});
  return scene;
}

std::vector<float> first_sample(const Scene& scene) {
  const Tracer tracer(scene);
  const SampleTile tile = sample_tile(make_view_sampler(scene, tracer, 16, 16, 1, 1), 0);
  return {tile.types[0].values.begin(), tile.types[0].values.begin() + 15};
}

TEST(Ggx, TakesItsFieldsFromBaseColourMetallicAndRoughness) {
  Scene scene = make_textured_scene();
  scene.materials[0].parameters = {{"base_color", vec3(0.5f, 0.25f, 1)},
                                   {"metallic", vec3(0.5f), 0, 2},
                                   {"roughness", vec3(0.5f), 0, 1}};
  const std::vector<float> v = first_sample(scene);
  const float f0 = 0.5f * 0.04f + 0.5f;
  EXPECT_NEAR(v[7], 0.5f * 0.5f * 0.96f, 1e-6f);
  EXPECT_NEAR(v[9], 0.5f * 0.96f, 1e-6f);
  EXPECT_NEAR(v[13], f0, 1e-6f);
  EXPECT_NEAR(v[12], 1, 1e-6f);
  EXPECT_NEAR(v[10] * v[13], 0.5f * 0.04f + 0.5f * 0.5f, 1e-6f);
  EXPECT_NEAR(v[14], 0.2f, 1e-6f);
}

/// x of the map is 0.6, y 0, z 0.8.
TEST(NormalMap, TurnsNormalsAlongUAndV) {
  Scene scene = make_textured_scene();
  scene.textures[0].texels = {204, 128, 230, 255};
  scene.materials[0].normal_texture = 0;
  std::vector<float> v = first_sample(scene);
  EXPECT_NEAR(v[4], 0.6f, 0.01f);
  EXPECT_NEAR(v[5], 0, 0.01f);
  EXPECT_NEAR(v[6], 0.8f, 0.01f);
  auto& mesh = std::get<Mesh>(scene.prototypes[0].shapes[0]);
  mesh.uvs = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};  // u upwards, v to the right: mirrored
  v = first_sample(scene);
  EXPECT_NEAR(v[4], 0, 0.01f);
  EXPECT_NEAR(v[5], 0.6f, 0.01f);
  mesh.tangents.assign(4, vec4(-1, 0, 0, 1));
  v = first_sample(scene);
  EXPECT_NEAR(v[4], -0.6f, 0.01f);
  scene.materials[0].normal_scale = 0;
  v = first_sample(scene);
  EXPECT_NEAR(v[6], 1, 1e-6f);
}

TEST(NormalMap, LeavesNormalsThatHaveNoDirectionsAndTurnsThoseOfMirroredCopies) {
  Scene scene = make_textured_scene();
  scene.textures[0].texels = {128, 204, 230, 255};
  scene.materials[0].normal_texture = 0;
  EXPECT_NEAR(first_sample(scene)[5], 0.6f, 0.01f);
  scene.instances[0].world_from_local[1] *= -1.0f;
  EXPECT_NEAR(first_sample(scene)[5], -0.6f, 0.01f);
  auto& mesh = std::get<Mesh>(scene.prototypes[0].shapes[0]);
  mesh.tangents.assign(4, vec4(1, 0, 0, 1));
  EXPECT_NEAR(first_sample(scene)[5], -0.6f, 0.01f);
  mesh.tangents.clear();
  mesh.uvs.assign(4, vec2(0.5f));
  EXPECT_EQ(first_sample(scene)[5], 0);
}

}  // namespace
}  // namespace relume
