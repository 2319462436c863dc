#include "viewer/session/pixel_maps.h"

#include <functional>

#include "core/relight/block_decoder.h"
#include "core/samples/sample_tile.h"
#include "core/shade/reference.h"
#include "core/trace/ray_bias.h"

namespace relume {
namespace {

/// A record as it is decoded.
struct DecodedRecord {
  size_t type = 0;
  float weight = 0;
  std::vector<float> values;  ///< of its type's width
};

using RecordVisitor = std::function<void(int x, int y, const DecodedRecord& record)>;

/// Calls visit(x, y, record) for the records of a block.
void visit_block(const CacheInfo& info, const PackedTile& tile, const PackedBlock& block,
                 const float* words, const RecordVisitor& visit) {
  DecodedRecord record;
  for (size_t t = 0; t < info.types.size(); ++t) {
    const auto width = static_cast<size_t>(info.types[t].width);
    record.type = t;
    record.values.resize(width);
    for (int slot = 0; slot < block.slots[t]; ++slot) {
      for (int lane = 0; lane < block.lanes; ++lane) {
        record.weight = words[lane];
        if (!(record.weight > 0)) continue;
        for (size_t i = 0; i < width; ++i) record.values[i] = words[(1 + i) * block_lanes + lane];
        visit(tile.x0 + block.pixels[lane] % tile_size, tile.y0 + block.pixels[lane] / tile_size,
              record);
      }
      words += (1 + width) * block_lanes;
    }
  }
}

void visit_tile(const RelightCache& cache, const BlockDecoder& decoder, const PackedTile& tile,
                const RecordVisitor& visit) {
  std::vector<float> scratch;
  for (int b = 0; b < tile.block_count; ++b) {
    const PackedBlock block = cache.block(tile, b);
    visit_block(cache.info(), tile, block, decoder.floats(block, scratch), visit);
  }
}

void visit_records(const RelightCache& cache, const RecordVisitor& visit) {
  const BlockDecoder decoder(cache, InstructionSet::automatic);
  for (const PackedTile& tile : cache.tiles()) visit_tile(cache, decoder, tile, visit);
}

vec3 read_vector(const DecodedRecord& record, int offset) {
  const float* values = &record.values[static_cast<size_t>(offset)];
  return {values[0], values[1], values[2]};
}

/// True when a traced ray from the record meets nothing before the light.
bool is_visible(const Tracer& tracer, const SampleType& type, const DecodedRecord& record,
                const Light& light) {
  const vec3 position = read_vector(record, type.offsets[position_field]);
  const float bias = record.values[static_cast<size_t>(type.offsets[bias_field])];
  const int normal_offset = field_offset(type, FieldSource::normal);
  const vec3 normal = normal_offset >= 0 ? read_vector(record, normal_offset) : vec3(0);
  vec3 wi = -normalize_or(light.direction, vec3(0, -1, 0));
  float distance = std::numeric_limits<float>::infinity();
  if (light.type != LightType::directional) {
    wi = normalize_or(light.position - position, wi);
    distance = glm::distance(light.position, position);
  }
  return !tracer.occluded(
      make_shadow_ray(position, normal_offset >= 0 ? &normal : nullptr, bias, wi, distance));
}

vec3 finite_or_black(dvec3 v) {
  const vec3 narrow(v);
  return is_finite(narrow) ? narrow : vec3(0);
}

void add_record(const CacheInfo& info, const Tracer* tracer, std::span<const Light> lights,
                const DecodedRecord& record, PixelReport& report) {
  const SampleType& type = info.types[record.type];
  InspectedRecord inspected;
  inspected.type = type.name;
  inspected.weight = record.weight;
  inspected.position = read_vector(record, type.offsets[position_field]);
  for (size_t i = 0; i < lights.size(); ++i) {
    const Light& light = lights[i];
    if (light.mute) continue;
    const bool is_dark =
        tracer != nullptr && light.casts_shadow && !is_visible(*tracer, type, record, light);
    if (is_dark) continue;
    const dvec3 response = reference_response(type, record.values.data(), light,
                                              dvec3(info.camera.eye), info.bounds.radius());
    const vec3 value =
        finite_or_black(static_cast<double>(record.weight) * response * dvec3(light.weight()));
    inspected.radiance += value;
    report.light_values[i] += value;
  }
  report.records.push_back(std::move(inspected));
}

}  // namespace

vec3 type_color(size_t type) {
  // Okabe and Ito's colours, told apart by all kinds of colour vision.
  constexpr std::array<vec3, 8> palette = {vec3(0.90f, 0.62f, 0.00f), vec3(0.34f, 0.71f, 0.91f),
                                           vec3(0.00f, 0.62f, 0.45f), vec3(0.94f, 0.89f, 0.26f),
                                           vec3(0.00f, 0.45f, 0.70f), vec3(0.84f, 0.37f, 0.00f),
                                           vec3(0.80f, 0.47f, 0.65f), vec3(0.75f, 0.75f, 0.75f)};
  return palette[type % palette.size()];
}

Image type_map(const RelightCache& cache) {
  const CacheInfo& info = cache.info();
  const size_t types = info.types.size();
  std::vector<float> weights(static_cast<size_t>(info.width) * info.height * types);
  visit_records(cache, [&](int x, int y, const DecodedRecord& record) {
    const size_t pixel = static_cast<size_t>(y) * info.width + x;
    weights[pixel * types + record.type] += record.weight;
  });
  Image map(info.width, info.height);
  for (size_t pixel = 0; pixel < map.pixel_count(); ++pixel) {
    const float* first = weights.data() + pixel * types;
    const float* heaviest = std::max_element(first, first + types);
    if (types == 0 || !(*heaviest > 0)) continue;
    const vec3 color = type_color(static_cast<size_t>(heaviest - first));
    for (int c = 0; c < 3; ++c) map.pixels[3 * pixel + c] = color[c];
  }
  return map;
}

Image normal_map(const RelightCache& cache) {
  const CacheInfo& info = cache.info();
  Image map(info.width, info.height);
  std::vector<uint8_t> is_covered(map.pixel_count());
  visit_records(cache, [&](int x, int y, const DecodedRecord& record) {
    const SampleType& type = info.types[record.type];
    int offset = field_offset(type, FieldSource::normal);
    if (offset < 0) offset = field_offset(type, FieldSource::tangent);
    if (offset < 0) return;
    const vec3 v = record.weight * read_vector(record, offset);
    float* pixel = map.at(x, y);
    for (int c = 0; c < 3; ++c) pixel[c] += v[c];
    is_covered[static_cast<size_t>(y) * info.width + x] = 1;
  });
  for (size_t pixel = 0; pixel < map.pixel_count(); ++pixel) {
    if (is_covered[pixel] == 0) continue;
    const vec3 shown = 0.5f + 0.5f * normalize_or(map.rgb(pixel), vec3(0));
    for (int c = 0; c < 3; ++c) map.pixels[3 * pixel + c] = shown[c];
  }
  return map;
}

PixelReport inspect_pixel(const RelightCache& cache, const Tracer* tracer,
                          std::span<const Light> lights, int x, int y) {
  const CacheInfo& info = cache.info();
  PixelReport report;
  report.light_values.assign(lights.size(), vec3(0));
  const BlockDecoder decoder(cache, InstructionSet::automatic);
  for (const PackedTile& tile : cache.tiles()) {
    const bool is_inside =
        x >= tile.x0 && x < tile.x0 + tile.width && y >= tile.y0 && y < tile.y0 + tile.height;
    if (!is_inside) continue;
    const size_t pixel = static_cast<size_t>(y - tile.y0) * tile.width + (x - tile.x0);
    report.coverage = static_cast<float>(tile.coverage[pixel]) / 255.0f;
    if (tile.emission != nullptr) std::copy_n(tile.emission + 3 * pixel, 3, &report.emission.x);
    visit_tile(cache, decoder, tile, [&](int px, int py, const DecodedRecord& record) {
      if (px == x && py == y) add_record(info, tracer, lights, record, report);
    });
  }
  return report;
}

}  // namespace relume
