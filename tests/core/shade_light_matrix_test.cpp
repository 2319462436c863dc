#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/math/frame.h"
#include "core/shade/light_matrix.h"
#include "core/shade/reference.h"
#include "core/shade/shaders.h"

namespace relume::test {
namespace {

constexpr vec3 eye(0.3f, 0.4f, 5.0f);
constexpr float scene_radius = 1;

std::vector<SampleType> all_types() {
  std::vector<SampleType> types;
  for (const ShaderInfo* shader : shader_table()) types.push_back(make_sample_type(*shader));
  return types;
}

/// Lights of every kind, more than one group of 16 points.
std::vector<Light> mixed_lights() {
  std::vector<Light> lights;
  Random random(3, RandomStream::tests, 0);
  for (int i = 0; i < 40; ++i) {
    Light light;
    light.type = i % 5 == 0   ? LightType::directional
                 : i % 5 == 1 ? LightType::spot
                              : LightType::point;
    light.falloff = i % 2 == 0;
    light.range = i % 3 == 0 ? 4.0f : 0.0f;
    light.position.x = random.uniform(-3, 3);
    light.position.y = random.uniform(-3, 3);
    light.position.z = random.uniform(1, 4);
    light.direction = -light.position;
    light.outer_angle_deg = 50;
    light.color = vec3(1, 0.5f, 0.25f);
    light.gain = random.uniform(1, 9);
    lights.push_back(light);
  }
  return lights;
}

std::vector<float> random_vector(const SampleType& type, uint64_t index) {
  Random random(4, RandomStream::tests, index);
  std::vector<float> v(type.width);
  for (float& x : v) x = random.uniform(0.1f, 0.6f);
  const float y = random.uniform(-0.8f, 0.8f);
  const float x = random.uniform(-0.8f, 0.8f);
  const vec3 direction = normalize_or(vec3(x, y, 0.9f), vec3(0, 0, 1));
  for (int axis = 0; axis < 3; ++axis) v[4 + axis] = direction[axis];
  if (type.width == 14) v[13] = random.uniform(2, 30);
  if (type.width == 15) v[14] = random.uniform(0.3f, 0.9f);
  return v;
}

class LightMatrix : public testing::TestWithParam<InstructionSet> {
 protected:
  void SetUp() override {
    if (!is_supported(GetParam())) GTEST_SKIP() << "this processor lacks the instruction set";
  }
  const std::vector<SampleType> types = all_types();
  const LightSet lights = make_light_set(mixed_lights(), scene_radius);
};

TEST_P(LightMatrix, EqualsTheDoubleReference) {
  const LobeEvaluator evaluator(types, lights, eye, GetParam());
  const auto columns = static_cast<size_t>(lights.columns());
  std::vector<float> lobes(max_lobes * columns);
  std::vector<float> v(3 * columns);
  for (size_t t = 0; t < types.size(); ++t) {
    for (uint64_t i = 0; i < 20; ++i) {
      const std::vector<float> vector = random_vector(types[t], i);
      evaluator.lobes(static_cast<int>(t), vector.data(), lobes.data());
      shade_rows(evaluator, static_cast<int>(t), vector.data(), 1, lobes.data(), v.data());
      for (size_t j = 0; j < columns; ++j) {
        const bool padding = lights.weights[0][j] == 0;
        const dvec3 unit =
            reference_response(types[t], vector.data(), lights.lights[j], dvec3(eye), scene_radius);
        for (size_t c = 0; c < 3; ++c) {
          const double expected =
              padding ? 0 : unit[c] * lights.lights[j].weight()[static_cast<int>(c)];
          ASSERT_NEAR(v[c * columns + j], expected, 2e-4 * (0.1 + std::abs(expected)))
              << types[t].name << " light " << j;
        }
      }
    }
  }
}

TEST_P(LightMatrix, DerivativesEqualFiniteDifferences) {
  const LobeEvaluator evaluator(types, lights, eye, GetParam());
  const auto columns = static_cast<size_t>(lights.columns());
  std::vector<float> derivatives(max_lobes * 4 * columns);
  std::vector<float> low(max_lobes * columns);
  std::vector<float> high(max_lobes * columns);
  const float h = 2e-3f;
  for (size_t t = 0; t < types.size(); ++t) {
    const int type = static_cast<int>(t);
    const std::vector<float> vector = random_vector(types[t], 7);
    const int offset = evaluator.direction_offset(type);
    const Frame frame = make_frame(vec3(vector[offset], vector[offset + 1], vector[offset + 2]));
    evaluator.lobes_and_derivatives(type, vector.data(), frame.tangent, frame.bitangent,
                                    derivatives.data());
    for (int d = 0; d < lobe_derivatives; ++d) {
      if (d == 2 && evaluator.scalar_offset(type) < 0) continue;
      const auto moved = [&](float step) {
        std::vector<float> v = vector;
        if (d == 2) {
          v[evaluator.scalar_offset(type)] *= std::exp(step);
        } else {
          const vec3 tangent = d == 0 ? frame.tangent : frame.bitangent;
          for (int axis = 0; axis < 3; ++axis) v[offset + axis] += step * tangent[axis];
        }
        return v;
      };
      evaluator.lobes(type, moved(-h).data(), low.data());
      evaluator.lobes(type, moved(h).data(), high.data());
      for (int k = 0; k < evaluator.lobe_count(type); ++k) {
        for (size_t j = 0; j < columns; ++j) {
          const size_t value = k * columns + j;
          // Where a lobe is cut off at the horizon the slope jumps: skip what lies at the edge.
          if (low[value] <= 0 || high[value] <= 0) continue;
          const double expected = (double{high[value]} - low[value]) / (2.0 * h);
          ASSERT_NEAR(derivatives[(k * 4 + 1 + d) * columns + j], expected,
                      0.02 * std::abs(expected) + 2e-3)
              << types[t].name << " lobe " << k << " derivative " << d << " light " << j;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, LightMatrix,
                         testing::Values(InstructionSet::scalar, InstructionSet::sse42,
                                         InstructionSet::avx2, InstructionSet::avx512),
                         [](const auto& set) {
                           const std::string name(label_of(instruction_set_labels, set.param));
                           return name == "sse4.2" ? std::string("sse42") : name;
                         });

}  // namespace
}  // namespace relume::test
