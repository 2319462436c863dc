#include "tests/support/records.h"

#include <cmath>

#include "core/samples/cache_writer.h"
#include "core/shade/shaders.h"

namespace relume::test {

vec3 random_direction(Random& random) {
  const float z = random.uniform(-1, 1);
  const float phi = random.uniform(0, 2 * pi);
  const float r = std::sqrt(std::max(0.0f, 1 - z * z));
  return normalize_or({r * std::cos(phi), r * std::sin(phi), z}, {0, 0, 1});
}

void append_random_vector(const SampleType& type, Random& random, std::vector<float>& values) {
  for (size_t i = 0; i < type.field_count(); ++i) {
    const SampleField& field = type.field(i);
    vec3 value(0);
    switch (field.kind) {
      case FieldKind::anchor:
        value = random_direction(random);
        value *= std::cbrt(random.uniform());
        break;
      case FieldKind::direction:
      case FieldKind::axis:
        value = random_direction(random);
        break;
      case FieldKind::scalar: {
        const float choice = random.uniform();
        const float usual =
            field.high > 1 ? std::pow(10.0f, random.uniform(-1, 5)) : random.uniform();
        value = vec3(choice < 0.1f ? 0.0f : choice < 0.2f ? field.high : usual);
        if (field.source == FieldSource::bias) value = vec3(1e-4f);
        break;
      }
      case FieldKind::linear: {
        value.x = random.uniform();
        value.y = random.uniform();
        value.z = random.uniform();
        break;
      }
    }
    for (int c = 0; c < field.width; ++c) values.push_back(value[c]);
  }
}

void widen_highlight(const SampleType& type, float* vector) {
  for (size_t i = 0; i < type.field_count(); ++i) {
    float& value = vector[type.offsets[i]];
    if (type.field(i).name == "exponent") value = std::min(value, 40.0f);
    if (type.field(i).name == "roughness") value = std::max(value, 0.4f);
  }
}

void widen_highlights(std::span<const SampleType> types, SampleTile& tile) {
  for (size_t t = 0; t < types.size(); ++t) {
    std::vector<float>& values = tile.types[t].values;
    for (size_t i = 0; i < values.size(); i += types[t].width)
      widen_highlight(types[t], &values[i]);
  }
}

SampleTile make_random_tile(std::span<const SampleType> types, int width, int height, int max_rows,
                            uint64_t seed) {
  SampleTile tile;
  tile.width = width;
  tile.height = height;
  tile.types.resize(types.size());
  const float weight = 1.0f / static_cast<float>(std::max<size_t>(1, max_rows * types.size()));
  for (TypedRows& rows : tile.types) rows.first.push_back(0);
  for (int pixel = 0; pixel < tile.pixel_count(); ++pixel) {
    Random random(seed, RandomStream::tests, pixel);
    for (size_t t = 0; t < types.size(); ++t) {
      const uint32_t count = random.below(static_cast<uint32_t>(max_rows) + 1);
      for (uint32_t i = 0; i < count; ++i) {
        append_random_vector(types[t], random, tile.types[t].values);
        tile.types[t].weights.push_back(weight);
      }
      tile.types[t].first.push_back(static_cast<uint32_t>(tile.types[t].rows()));
    }
  }
  return tile;
}

std::vector<SampleTile> make_random_tiles(std::span<const SampleType> types, int width, int height,
                                          int max_rows) {
  std::vector<SampleTile> tiles;
  for (int y = 0; y < height; y += tile_size) {
    for (int x = 0; x < width; x += tile_size) {
      tiles.push_back(make_random_tile(types, std::min(tile_size, width - x),
                                       std::min(tile_size, height - y), max_rows, tiles.size()));
      tiles.back().x0 = x;
      tiles.back().y0 = y;
    }
  }
  return tiles;
}

void fill_predicted_error(SampleTile& tile) {
  for (int y = 0; y < tile.height; ++y) {
    for (int x = 0; x < tile.width; ++x) {
      tile.predicted_error.push_back(0.001f *
                                     static_cast<float>(1 + tile.x0 + x + 3 * (tile.y0 + y)));
    }
  }
}

std::vector<SampleType> all_sample_types() {
  std::vector<SampleType> types;
  for (const ShaderInfo* shader : shader_table()) types.push_back(make_sample_type(*shader));
  return types;
}

CacheInfo make_tile_info(const SampleTile& tile, const std::vector<SampleType>& types, vec3 eye) {
  CacheInfo info;
  info.width = tile.width;
  info.height = tile.height;
  info.camera.eye = eye;
  info.camera.target = eye == vec3(0) ? vec3(0, 0, 1) : vec3(0);
  info.types = types;
  info.bounds.extend(vec3(-0.5773503f));
  info.bounds.extend(vec3(0.5773503f));
  info.method = "all";
  info.spp = 25;
  info.scene_name = "records";
  return info;
}

RelightCache make_tile_cache(const SampleTile& tile, const std::vector<SampleType>& types,
                             vec3 eye) {
  CacheWriter writer;
  writer.add(pack_tile(tile, types));
  writer.finish(make_tile_info(tile, types, eye));
  return RelightCache::from_bytes(writer.take_bytes(), shader_table(), "records");
}

}  // namespace relume::test
