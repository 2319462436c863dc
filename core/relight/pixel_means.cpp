#include "core/relight/pixel_means.h"

#include "core/base/parallel.h"
#include "core/relight/block_decoder.h"
#include "core/samples/sample_tile.h"

namespace relume {
namespace {

/// One record of a block: component i of its sample vector is values[i * block_lanes].
struct RecordView {
  const SampleType& type;
  const float* values;

  vec3 vector(int offset) const {
    const float* first = values + static_cast<ptrdiff_t>(offset) * block_lanes;
    return {first[0], first[block_lanes], first[2 * block_lanes]};
  }
};

/// The direction across a strand that faces the eye; 0 where the strand points at the eye.
vec3 strand_normal(vec3 tangent, vec3 position, vec3 eye) {
  const vec3 wo = normalize_or(eye - position, vec3(0));
  return normalize_or(wo - glm::dot(wo, tangent) * tangent, vec3(0));
}

vec3 diffuse_of(const RecordView& record) {
  for (size_t i = 0; i < record.type.field_count(); ++i) {
    if (record.type.field(i).name == "diffuse") return record.vector(record.type.offsets[i]);
  }
  return vec3(0);
}

vec3 value_of_record(const RecordView& record, MeanField field, vec3 eye) {
  const vec3 position = record.vector(record.type.offsets[position_field]);
  switch (field) {
    case MeanField::position:
      return position;
    case MeanField::normal: {
      const int normal = field_offset(record.type, FieldSource::normal);
      if (normal >= 0) return record.vector(normal);
      const int tangent = field_offset(record.type, FieldSource::tangent);
      return tangent < 0 ? vec3(0) : strand_normal(record.vector(tangent), position, eye);
    }
    case MeanField::albedo:
      return diffuse_of(record);
  }
  return vec3(0);
}

/// Weighted sum and weight of one lane's records.
struct LaneSum {
  dvec3 sum{0};
  double weight = 0;
};

LaneSum sum_lane(const CacheInfo& info, const PackedBlock& block, const float* records, int lane,
                 MeanField field) {
  LaneSum total;
  for (size_t t = 0; t < info.types.size(); ++t) {
    const SampleType& type = info.types[t];
    for (int slot = 0; slot < block.slots[t]; ++slot) {
      const float weight = records[lane];
      if (weight > 0) {
        const RecordView record{type, records + block_lanes + lane};
        total.sum += double{weight} * dvec3(value_of_record(record, field, info.camera.eye));
        total.weight += weight;
      }
      records += (1 + type.width) * block_lanes;
    }
  }
  return total;
}

}  // namespace

Image pixel_means(const RelightCache& cache, MeanField field) {
  const CacheInfo& info = cache.info();
  const BlockDecoder decoder(cache, InstructionSet::automatic);
  const auto tiles = cache.tiles();
  // In packed formats a record's colour is multiplied by the weight that it does not keep.
  const bool by_coverage = info.format != CacheFormat::exact && field == MeanField::albedo;
  Image means(info.width, info.height);
  parallel_for(tiles.size(), 1, [&](size_t begin, size_t end) {
    std::vector<float> scratch;
    for (size_t t = begin; t < end; ++t) {
      const PackedTile& tile = tiles[t];
      for (int b = 0; b < tile.block_count; ++b) {
        const PackedBlock block = cache.block(tile, b);
        const float* records = decoder.floats(block, scratch);
        for (int lane = 0; lane < block.lanes; ++lane) {
          const int x = block.pixels[lane] % tile_size;
          const int y = block.pixels[lane] / tile_size;
          const LaneSum total = sum_lane(info, block, records, lane, field);
          const double divisor =
              by_coverage ? tile.coverage[y * tile.width + x] / 255.0 : total.weight;
          if (!(total.weight > 0) || !(divisor > 0)) continue;
          const vec3 mean(total.sum / divisor);
          std::copy_n(&mean.x, 3, means.at(tile.x0 + x, tile.y0 + y));
        }
      }
    }
  });
  return means;
}

}  // namespace relume
