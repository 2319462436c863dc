#include "viewer/commands/bench_cuts.h"

#include <algorithm>
#include <utility>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/relight/block_decoder.h"
#include "core/samples/cache_writer.h"
#include "core/shade/shaders.h"

namespace relume {
namespace {

/// Position, bias, direction and diffuse colour: the floats with which every shader's samples
/// start.
constexpr int shared_floats = 10;
constexpr float phong_exponent = 40;

/// One record of a tile, decoded.
struct TileRecord {
  size_t type;
  float weight;
  std::vector<float> values;
};

/// Records of each pixel of a tile, row-major.
using PixelRecords = std::vector<std::vector<TileRecord>>;

PixelRecords decode_tile(const RelightCache& cache, const BlockDecoder& decoder,
                         const PackedTile& tile) {
  PixelRecords pixels(static_cast<size_t>(tile.width) * tile.height);
  std::vector<float> scratch;
  for (int b = 0; b < tile.block_count; ++b) {
    const PackedBlock block = cache.block(tile, b);
    const float* slot = decoder.floats(block, scratch);
    for (size_t t = 0; t < cache.info().types.size(); ++t) {
      const int width = cache.info().types[t].width;
      for (int s = 0; s < block.slots[t]; ++s, slot += (1 + width) * block_lanes) {
        for (int lane = 0; lane < block.lanes; ++lane) {
          if (!(slot[lane] > 0)) continue;
          const int place = block.pixels[lane];
          TileRecord record{t, slot[lane], {}};
          for (int i = 0; i < width; ++i) {
            record.values.push_back(slot[(1 + i) * block_lanes + lane]);
          }
          pixels[place / tile_size * tile.width + place % tile_size].push_back(std::move(record));
        }
      }
    }
  }
  return pixels;
}

void set_record_count(std::vector<TileRecord>& records, size_t count) {
  const size_t had = records.size();
  if (had == 0) return;
  for (size_t i = had; i < count; ++i) records.push_back(TileRecord(records[i % had]));
  records.resize(count);
}

SampleTile to_sample_tile(const PackedTile& tile, int y0, const PixelRecords& pixels,
                          size_t types) {
  SampleTile result{tile.x0, y0, tile.width, tile.height, {}, {}, {}, {}};
  result.types.resize(types);
  for (TypedRows& rows : result.types) rows.first.push_back(0);
  for (size_t p = 0; p < pixels.size(); ++p) {
    for (const TileRecord& record : pixels[p]) {
      TypedRows& rows = result.types[record.type];
      rows.values.insert(rows.values.end(), record.values.begin(), record.values.end());
      rows.weights.push_back(record.weight);
    }
    for (TypedRows& rows : result.types) rows.first.push_back(static_cast<uint32_t>(rows.rows()));
    result.coverage.push_back(static_cast<float>(tile.coverage[p]) / 255.0f);
    if (tile.emission == nullptr) continue;
    const float* const emission = tile.emission + 3 * p;
    result.emission.emplace_back(emission[0], emission[1], emission[2]);
  }
  return result;
}

/// The rows of tiles that a cut keeps: all, or `count` of the full ones, spread over the picture.
std::vector<int> choose_tile_rows(int height, int count) {
  const int all = (height + tile_size - 1) / tile_size;
  const int full = height / tile_size;
  std::vector<int> rows;
  if (count <= 0 || count > full) {
    for (int i = 0; i < all; ++i) rows.push_back(i);
  } else {
    for (int i = 0; i < count; ++i) rows.push_back((2 * i + 1) * full / (2 * count));
  }
  return rows;
}

/// `tile_rows` rows of tiles with each pixel's records as `change` leaves them, which are of
/// `types` then.
template <class Change>
RelightCache rebuild_cache(const RelightCache& cache, std::vector<SampleType> types, int tile_rows,
                           const Change& change) {
  CacheInfo info = cache.info();
  const std::vector<int> rows = choose_tile_rows(info.height, tile_rows);
  info.height = std::min(info.height, static_cast<int>(rows.size()) * tile_size);
  info.types = std::move(types);
  const BlockDecoder decoder(cache, InstructionSet::automatic);
  const size_t across = (info.width + tile_size - 1) / tile_size;
  std::vector<PackedTileData> packed(across * rows.size());
  parallel_for(packed.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const PackedTile& tile = cache.tiles()[rows[i / across] * across + i % across];
      PixelRecords pixels = decode_tile(cache, decoder, tile);
      for (std::vector<TileRecord>& records : pixels) change(records);
      const int y0 = static_cast<int>(i / across) * tile_size;
      packed[i] = pack_tile(to_sample_tile(tile, y0, pixels, info.types.size()), info.types,
                            {info.format, info.camera});
    }
  });
  CacheWriter writer;
  for (PackedTileData& tile : packed) writer.add(std::exchange(tile, {}));
  writer.finish(info);
  return RelightCache::from_bytes(writer.take_bytes(), shader_table(), "cut");
}

SampleType shader_type(std::string_view name) {
  const auto table = shader_table();
  const auto found = std::find_if(table.begin(), table.end(),
                                  [&](const ShaderInfo* shader) { return shader->name == name; });
  CHECK(found != table.end());
  return make_sample_type(**found);
}

}  // namespace

RelightCache cut_cache(const RelightCache& cache, const CutParams& params) {
  return rebuild_cache(cache, cache.info().types, params.tile_rows,
                       [&](std::vector<TileRecord>& records) {
                         if (params.records > 0) set_record_count(records, params.records);
                       });
}

RelightCache make_diffuse_cache(const RelightCache& cache, DiffuseShader shader, int tile_rows) {
  const SampleType type = shader_type(shader == DiffuseShader::lambert ? "lambert" : "phong");
  return rebuild_cache(cache, {type}, tile_rows, [&](std::vector<TileRecord>& records) {
    for (TileRecord& record : records) {
      record.type = 0;
      record.values.resize(shared_floats);
      record.values.resize(type.width, 0.0f);
      if (shader == DiffuseShader::phong) record.values.back() = phong_exponent;
    }
  });
}

int tile_rows_for(const CacheInfo& info, double records, double records_per_pixel) {
  const double rows = records / records_per_pixel / info.width / tile_size;
  return static_cast<int>(std::clamp(rows, 1.0, 1e4));
}

}  // namespace relume
