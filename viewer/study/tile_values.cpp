#include "viewer/study/tile_values.h"

#include "core/base/check.h"
#include "core/shade/shaders.h"

namespace relume {
namespace {

/// Rows of one pixel and type as arrays, the shape in which visibility is asked for.
struct RowReceivers {
  std::vector<float> values;
  Receivers receivers;

  void fill(const SampleType& type, const float* rows, int count) {
    values.assign(static_cast<size_t>(count) * 8, 1.0f);
    const int normal = field_offset(type, FieldSource::normal);
    const auto copy = [&](int array, int offset) {
      float* to = &values[static_cast<size_t>(array) * count];
      for (int row = 0; row < count; ++row) to[row] = rows[row * type.width + offset];
      return to;
    };
    receivers = {};
    receivers.count = count;
    receivers.weight = &values[static_cast<size_t>(7) * count];
    for (int c = 0; c < 3; ++c) {
      receivers.position[c] = copy(c, type.offsets[position_field] + c);
      if (normal >= 0) receivers.normal[c] = copy(3 + c, normal + c);
    }
    receivers.bias = copy(6, type.offsets[bias_field]);
    receivers.lit_from_behind = type.shader->two_sided_transmission;
  }
};

/// What one thread needs to look at rows.
struct RowScratch {
  std::vector<float> lobes;
  std::vector<float> v;           ///< 3 x columns
  std::vector<float> visibility;  ///< light by light, of the rows of a pixel and type
  RowReceivers receivers;
};

void trace_rows(const SampleType& type, const float* rows, int count, const TestLights& lights,
                std::span<const VisibilitySource* const> shadows, RowScratch& scratch) {
  scratch.receivers.fill(type, rows, count);
  scratch.visibility.assign(lights.count() * count, 1.0f);
  for (size_t light = 0; light < lights.count(); ++light) {
    const VisibilitySource* source = shadows[lights.columns[light]];
    if (source == nullptr) continue;
    source->visibility(scratch.receivers.receivers, &scratch.visibility[light * count]);
  }
}

/// Adds the rows of one pixel and type to the pixel's values.
void add_rows(const TestLights& lights, int type, const TypedRows& rows, int pixel, bool traced,
              RowScratch& scratch, TileValues& out) {
  const LobeEvaluator& evaluator = lights.set.evaluator;
  const auto columns = static_cast<size_t>(evaluator.lights().columns());
  const auto width = static_cast<size_t>(evaluator.vector_width(type));
  const uint32_t first = rows.first[pixel];
  const uint32_t count = rows.first[pixel + 1] - first;
  const size_t at = static_cast<size_t>(pixel) * 3 * lights.count();
  for (uint32_t row = 0; row < count; ++row) {
    const float* vector = &rows.values[(first + row) * width];
    evaluator.lobes(type, vector, scratch.lobes.data());
    shade_rows(evaluator, type, vector, 1, scratch.lobes.data(), scratch.v.data());
    for (size_t c = 0; c < 3; ++c) {
      for (size_t light = 0; light < lights.count(); ++light) {
        const float value =
            rows.weights[first + row] * scratch.v[c * columns + lights.columns[light]];
        const size_t i = at + c * lights.count() + light;
        out.plain[i] += value;
        if (traced) out.traced[i] += value * scratch.visibility[light * count + row];
      }
    }
  }
}

}  // namespace

std::vector<const VisibilitySource*> TestLights::sources() const {
  std::vector<const VisibilitySource*> sources;
  for (const auto& source : shadows) sources.push_back(source.get());
  return sources;
}

TestLights make_test_lights(std::span<const Light> lights, const ViewSampler& view,
                            float scene_radius) {
  TestLights result{
      make_training_set(lights, view.types.types, view.rays.eye(), scene_radius), {}, {}};
  const LightSet& set = *result.set.lights;
  result.shadows.resize(set.columns());
  for (size_t column = 0; column < result.shadows.size(); ++column) {
    if (set.padding[column]) continue;
    result.columns.push_back(column);
    if (!set.lights[column].casts_shadow) continue;
    result.shadows[column] = std::make_unique<TracedVisibility>(*view.tracer);
    result.shadows[column]->prepare(set.lights[column]);
  }
  CHECK_MSG(result.count() == lights.size(), "{} {}", result.count(), lights.size());
  return result;
}

TileValues tile_values(const SampleTile& tile, std::span<const SampleType> types,
                       const TestLights& lights, std::span<const VisibilitySource* const> shadows) {
  const bool traced = !shadows.empty();
  const auto columns = static_cast<size_t>(lights.set.evaluator.lights().columns());
  const size_t values = static_cast<size_t>(tile.pixel_count()) * 3 * lights.count();
  TileValues out{std::vector<float>(values, 0.0f), std::vector<float>(traced ? values : 0, 0.0f)};
  RowScratch scratch;
  scratch.lobes.resize(max_lobes * columns);
  scratch.v.resize(3 * columns);
  for (size_t t = 0; t < tile.types.size(); ++t) {
    const TypedRows& rows = tile.types[t];
    for (int pixel = 0; pixel < tile.pixel_count(); ++pixel) {
      const uint32_t count = rows.first[pixel + 1] - rows.first[pixel];
      if (count == 0) continue;
      if (traced) {
        trace_rows(types[t], &rows.values[size_t{rows.first[pixel]} * types[t].width],
                   static_cast<int>(count), lights, shadows, scratch);
      }
      add_rows(lights, static_cast<int>(t), rows, pixel, traced, scratch, out);
    }
  }
  return out;
}

}  // namespace relume
