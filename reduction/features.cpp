#include "reduction/features.h"

#include "core/base/check.h"

namespace relume {
namespace {

constexpr float direction_scale = 1.0f;
constexpr float linear_scale = 2.0f;
constexpr float log_scalar_scale = 0.3f;

bool is_clustered(const SampleField& field) {
  return field.source != FieldSource::bias;
}

/// Sizes `features` for the clustered fields and returns the mean of every sample float.
std::vector<double> start_features(const SampleMatrix& samples, Features& features) {
  const SampleType& type = *samples.type;
  features.rows = samples.rows;
  features.dimensions = 0;
  for (size_t f = 0; f < type.field_count(); ++f) {
    if (is_clustered(type.field(f))) features.dimensions += type.field(f).width;
  }
  features.values.resize(static_cast<size_t>(features.rows) * features.dimensions);
  std::vector<double> mean(type.width, 0.0);
  for (int row = 0; row < samples.rows; ++row) {
    for (int i = 0; i < type.width; ++i) mean[i] += samples.row(row)[i];
  }
  for (double& value : mean) value /= std::max(1, samples.rows);
  return mean;
}

/// -1 when the axis lies on the other side of the first row's.
float axis_sign(const SampleMatrix& samples, int row, int offset) {
  const float* a = samples.row(0) + offset;
  const float* b = samples.row(row) + offset;
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] < 0 ? -1.0f : 1.0f;
}

}  // namespace

void make_raw_features(const SampleMatrix& samples, Features& features) {
  const std::vector<double> mean = start_features(samples, features);
  const SampleType& type = *samples.type;
  float* out = features.values.data();
  for (int row = 0; row < samples.rows; ++row) {
    for (size_t f = 0; f < type.field_count(); ++f) {
      if (!is_clustered(type.field(f))) continue;
      for (int c = 0; c < type.field(f).width; ++c) {
        const int i = type.offsets[f] + c;
        *out++ = static_cast<float>(samples.row(row)[i] - mean[i]);
      }
    }
  }
}

void make_scaled_features(const SampleMatrix& samples, float scene_radius, Features& features) {
  CHECK_MSG(scene_radius > 0, "scene radius {}", scene_radius);
  const std::vector<double> mean = start_features(samples, features);
  const SampleType& type = *samples.type;
  const double position_scale = 1.0 / scene_radius;
  float* out = features.values.data();
  for (int row = 0; row < samples.rows; ++row) {
    const float* values = samples.row(row);
    for (size_t f = 0; f < type.field_count(); ++f) {
      const SampleField& field = type.field(f);
      if (!is_clustered(field)) continue;
      const int offset = type.offsets[f];
      const float sign = field.kind == FieldKind::axis ? axis_sign(samples, row, offset) : 1.0f;
      for (int c = 0; c < field.width; ++c) {
        const float value = values[offset + c];
        switch (field.kind) {
          case FieldKind::anchor:
            *out++ = static_cast<float>((value - mean[offset + c]) * position_scale);
            break;
          case FieldKind::direction:
          case FieldKind::axis:
            *out++ = sign * value * direction_scale;
            break;
          case FieldKind::linear:
            *out++ = value * linear_scale;
            break;
          case FieldKind::scalar:
            *out++ = log_scalar_scale * std::log1p(std::max(0.0f, value));
            break;
        }
      }
    }
  }
}

}  // namespace relume
