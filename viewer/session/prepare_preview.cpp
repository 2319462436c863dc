#include "viewer/session/prepare_preview.h"

#include "core/shade/reference.h"
#include "core/trace/ray_bias.h"

namespace relume {
namespace {

/// A record of a pixel.
struct RecordPlace {
  size_t type = 0;
  size_t row = 0;
};

vec3 read_vector(const float* values, int offset) {
  return {values[offset], values[offset + 1], values[offset + 2]};
}

bool is_visible(const ViewSampler& view, const SampleType& type, const float* vector,
                const Light& light) {
  const vec3 position = read_vector(vector, type.offsets[position_field]);
  const float bias = vector[type.offsets[bias_field]];
  const int normal_offset = field_offset(type, FieldSource::normal);
  const vec3 normal = normal_offset >= 0 ? read_vector(vector, normal_offset) : vec3(0);
  vec3 wi = -normalize_or(light.direction, vec3(0, -1, 0));
  float distance = std::numeric_limits<float>::infinity();
  if (light.type != LightType::directional) {
    wi = normalize_or(light.position - position, wi);
    distance = glm::distance(light.position, position);
  }
  return !view.tracer->occluded(
      make_shadow_ray(position, normal_offset >= 0 ? &normal : nullptr, bias, wi, distance));
}

/// The records of one pixel under all lights, and what it emits; the heaviest says which lights it
/// sees.
vec3 shade_pixel(const ViewSampler& view, const SampleTile& tile, size_t pixel) {
  const std::vector<SampleType>& types = view.types.types;
  std::vector<RecordPlace> records;
  RecordPlace heaviest;
  float largest = 0;
  for (size_t t = 0; t < tile.types.size(); ++t) {
    const TypedRows& rows = tile.types[t];
    for (size_t row = rows.first[pixel]; row < rows.first[pixel + 1]; ++row) {
      records.push_back({t, row});
      if (rows.weights[row] <= largest) continue;
      largest = rows.weights[row];
      heaviest = records.back();
    }
  }
  const dvec3 emission = tile.emission.empty() ? dvec3(0) : dvec3(tile.emission[pixel]);
  if (records.empty()) return vec3(emission);
  const auto vector_of = [&](const RecordPlace& record) {
    return &tile.types[record.type]
                .values[record.row * static_cast<size_t>(types[record.type].width)];
  };
  const double radius = view.tracer->bounds().radius();
  dvec3 sum = emission;
  for (const Light& light : view.scene->lights) {
    if (light.mute) continue;
    const bool seen =
        !light.casts_shadow || is_visible(view, types[heaviest.type], vector_of(heaviest), light);
    if (!seen) continue;
    dvec3 response(0);
    for (const RecordPlace& record : records) {
      response += static_cast<double>(tile.types[record.type].weights[record.row]) *
                  reference_response(types[record.type], vector_of(record), light,
                                     dvec3(view.rays.eye()), radius);
    }
    sum += response * dvec3(light.weight());
  }
  const vec3 color(sum);
  return is_finite(color) ? color : vec3(0);
}

}  // namespace

void PreparePreview::add_tile(const ViewSampler& view, const SampleTile& records) {
  std::vector<vec3> colors;
  for (int pixel = 0; pixel < records.pixel_count(); ++pixel) {
    colors.push_back(shade_pixel(view, records, static_cast<size_t>(pixel)));
  }
  bool first = false;
  {
    const std::lock_guard lock(mutex_);
    if (image_.width != view.width || image_.height != view.height) {
      image_ = Image(view.width, view.height);
    }
    exposure_ = view.scene->exposure;
    for (int y = 0; y < records.height; ++y) {
      for (int x = 0; x < records.width; ++x) {
        const vec3 color = colors[static_cast<size_t>(y) * records.width + x];
        float* pixel = image_.at(records.x0 + x, records.y0 + y);
        for (int c = 0; c < 3; ++c) pixel[c] = color[c];
      }
    }
    first = !fresh_;
    fresh_ = true;
  }
  if (first && notify_) notify_();
}

bool PreparePreview::take(Image& image, float& exposure) {
  const std::lock_guard lock(mutex_);
  if (!fresh_) return false;
  image = image_;
  exposure = exposure_;
  fresh_ = false;
  return true;
}

}  // namespace relume
