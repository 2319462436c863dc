#include "reduction/training.h"

#include <array>

#include "core/base/check.h"
#include "core/base/random.h"

namespace relume {
namespace {

constexpr int max_training_lights = 4096;

/// Index of the random numbers that shift the Halton sequence of a seed; no light has it.
constexpr uint64_t shift_index = ~uint64_t{0};

/// The radical inverse of `index` in base `base`, in [0, 1) (Halton 1960).
double radical_inverse(uint32_t base, uint64_t index) {
  double result = 0;
  double digit_weight = 1.0 / base;
  for (; index > 0; index /= base) {
    result += static_cast<double>(index % base) * digit_weight;
    digit_weight /= base;
  }
  return result;
}

/// Halton points of six dimensions, shifted around the unit cube (Cranley and Patterson 1976).
struct ShiftedHalton {
  static constexpr std::array<uint32_t, 6> bases{2, 3, 5, 7, 11, 13};
  std::array<double, 6> shift;

  explicit ShiftedHalton(uint64_t seed) {
    Random random(seed, RandomStream::lights, shift_index);
    for (double& value : shift) value = random.uniform();
  }
  float operator()(uint64_t index, size_t dimension) const {
    const double value = radical_inverse(bases[dimension], index + 1) + shift[dimension];
    return static_cast<float>(value - std::floor(value));
  }
  vec3 between(vec3 low, vec3 high, uint64_t index, size_t first_dimension) const {
    vec3 result(0);
    for (size_t c = 0; c < 3; ++c) {
      result[c] = low[c] + (high[c] - low[c]) * (*this)(index, first_dimension + c);
    }
    return result;
  }
};

/// Irradiance at `point` on a plane that faces the light, per unit of its weight.
double irradiance_at(const Light& light, vec3 point, double scene_radius) {
  if (light.type == LightType::directional || !light.falloff) return 1;
  const dvec3 offset = dvec3(light.position) - dvec3(point);
  return 1 / std::max({glm::dot(offset, offset), scene_radius * scene_radius, 1e-30});
}

/// A pixel's samples of one type as arrays, the shape in which visibility is asked for.
struct ReceiverArrays {
  std::vector<float> values;  ///< 8 x rows: position, normal, bias, weight 1
  Receivers receivers;

  void fill(const SampleMatrix& matrix) {
    const SampleType& type = *matrix.type;
    const int rows = matrix.rows;
    values.assign(static_cast<size_t>(rows) * 8, 1.0f);
    const auto array = [&](int i) { return values.data() + static_cast<size_t>(rows) * i; };
    const auto copy = [&](int field, int width, int first_array) {
      for (int c = 0; c < width; ++c) {
        for (int row = 0; row < rows; ++row) {
          array(first_array + c)[row] = matrix.row(row)[type.offsets[field] + c];
        }
      }
    };
    receivers = {.count = rows,
                 .weight = array(7),
                 .position = {array(0), array(1), array(2)},
                 .bias = array(6),
                 .lit_from_behind = type.shader->two_sided_transmission};
    copy(position_field, 3, 0);
    copy(bias_field, 1, 6);
    for (size_t f = 0; f < type.field_count(); ++f) {
      if (type.field(f).source != FieldSource::normal) continue;
      copy(static_cast<int>(f), 3, 3);
      for (int c = 0; c < 3; ++c) receivers.normal[c] = array(3 + c);
    }
  }
};

void shadow_rows(const TrainingSet& training, const SampleMatrix& matrix, ReceiverArrays& arrays,
                 std::vector<float>& visibility, float* v) {
  if (matrix.rows == 0) return;
  const int columns = training.lights->columns();
  arrays.fill(matrix);
  visibility.resize(matrix.rows);
  for (int column = 0; column < columns; ++column) {
    const VisibilitySource* source = training.visibility[column];
    if (source == nullptr) continue;
    source->visibility(arrays.receivers, visibility.data());
    for (int row = 0; row < matrix.rows; ++row) {
      float* value = v + static_cast<size_t>(row) * 3 * columns + column;
      for (int c = 0; c < 3; ++c) value[c * columns] *= visibility[row];
    }
  }
}

}  // namespace

TrainingParams report_faithful_training() {
  return {.lights = 200, .shadows = true};
}

std::vector<Light> make_training_lights(const Light& low, const Light& high,
                                        const TrainingParams& params) {
  CHECK_MSG(params.lights >= 1 && params.lights <= max_training_lights, "lights {}", params.lights);
  std::vector<Light> lights;
  for (int i = 0; i < params.lights; ++i) {
    lights.push_back(interpolate_light(low, high, params.seed, first_training_light + i));
  }
  return lights;
}

std::vector<Light> make_mixed_training_lights(const Light& low, const Light& high,
                                              const Bounds& scene, int count, uint64_t seed) {
  CHECK_MSG(count >= 1 && count <= max_training_lights, "count {}", count);
  const ShiftedHalton halton(seed);
  const int between = (3 * count + 3) / 4;
  std::vector<Light> lights;
  double irradiance = 0;
  for (int i = 0; i < between; ++i) {
    Light light = interpolate_light(low, high, seed, first_training_light + i);
    light.position = halton.between(low.position, high.position, i, 0);
    light.direction =
        normalize_or(halton.between(low.direction, high.direction, i, 3), low.direction);
    irradiance += irradiance_at(light, scene.center(), scene.radius()) / between;
    lights.push_back(light);
  }
  for (int i = 0; i < count - between; ++i) {
    Light light = lights[i % lights.size()];
    light.name += "-directional";
    light.type = LightType::directional;
    const float z = 1 - 2 * halton(i, 0);
    const float angle = 2 * pi * halton(i, 1);
    const float ring = std::sqrt(std::max(0.0f, 1 - z * z));
    light.direction = normalize_or({ring * std::cos(angle), ring * std::sin(angle), z}, {0, 0, 1});
    light.gain = static_cast<float>(std::min(light.gain * irradiance, 1e20));
    lights.push_back(light);
  }
  return lights;
}

TrainingSet make_training_set(std::span<const Light> lights, std::span<const SampleType> types,
                              vec3 eye, float scene_radius) {
  CHECK(!lights.empty());
  auto set = std::make_unique<const LightSet>(make_light_set(lights, scene_radius));
  LobeEvaluator evaluator(types, *set, eye);
  return {std::move(set), std::move(evaluator), {}};
}

void evaluate_training(const TrainingSet& training, std::span<const SampleMatrix> matrices,
                       float weight_per_sample, PixelResponses& responses) {
  evaluate_responses(training.evaluator, matrices, weight_per_sample, responses);
  if (training.visibility.empty()) return;
  CHECK_MSG(training.visibility.size() == training.lights->lights.size(), "{} sources, {} columns",
            training.visibility.size(), training.lights->lights.size());
  ReceiverArrays arrays;
  std::vector<float> visibility;
  for (size_t t = 0; t < matrices.size(); ++t) {
    shadow_rows(training, matrices[t], arrays, visibility, responses.v[t].data());
  }
  sum_target(matrices, weight_per_sample, responses);
}

}  // namespace relume
