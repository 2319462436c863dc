#include "core/relight/reference_relight.h"

#include "core/relight/block_decoder.h"
#include "core/relight/receivers.h"
#include "core/samples/sample_tile.h"
#include "core/shade/reference.h"

namespace relume {
namespace {

/// Sum of weight * visibility * response over one lane's records.
dvec3 shade_lane(const CacheInfo& info, const PackedBlock& block, const float* records, int lane,
                 const Light& light, const float* visibility) {
  dvec3 sum(0);
  float vector[64];
  for (size_t t = 0; t < info.types.size(); ++t) {
    const SampleType& type = info.types[t];
    for (int slot = 0; slot < block.slots[t]; ++slot) {
      const double weight = records[lane];
      const double seen = visibility != nullptr ? visibility[lane] : 1.0;
      for (int i = 0; i < type.width; ++i) vector[i] = records[(1 + i) * block_lanes + lane];
      if (weight > 0) {
        sum +=
            weight * seen *
            reference_response(type, vector, light, dvec3(info.camera.eye), info.bounds.radius());
      }
      records += (1 + type.width) * block_lanes;
      if (visibility != nullptr) visibility += block_lanes;
    }
  }
  return sum;
}

}  // namespace

Image reference_layer(const RelightCache& cache, const Light& light,
                      const VisibilitySource* shadows) {
  const CacheInfo& info = cache.info();
  Image layer(info.width, info.height);
  const BlockDecoder decoder(cache, InstructionSet::scalar);
  std::vector<float> decoded;
  std::vector<float> visibility;
  for (const PackedTile& tile : cache.tiles()) {
    size_t receiver = tile.first_slot * block_lanes;
    for (int b = 0; b < tile.block_count; ++b) {
      const PackedBlock block = cache.block(tile, b);
      const float* records = decoder.floats(block, decoded);
      if (shadows != nullptr) query_block(info, block, records, receiver, *shadows, visibility);
      for (size_t t = 0; t < info.types.size(); ++t)
        receiver += size_t{block.slots[t]} * block_lanes;
      for (int lane = 0; lane < block.lanes; ++lane) {
        const dvec3 rgb = shade_lane(info, block, records, lane, light,
                                     shadows != nullptr ? visibility.data() : nullptr);
        float* pixel = layer.at(tile.x0 + block.pixels[lane] % tile_size,
                                tile.y0 + block.pixels[lane] / tile_size);
        for (int c = 0; c < 3; ++c) pixel[c] = static_cast<float>(rgb[c]);
      }
    }
  }
  return layer;
}

}  // namespace relume
