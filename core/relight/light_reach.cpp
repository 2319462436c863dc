#include "core/relight/light_reach.h"

#include "core/base/parallel.h"
#include "core/relight/block_decoder.h"

namespace relume {
namespace {

/// Far above what the rounding of kernels turns a direction by.
constexpr double angle_margin = 1e-3;
constexpr double range_margin = 1e-3;  ///< likewise, of distances

void extend(Bounds& bounds, const CacheInfo& info, const PackedBlock& block, const float* records) {
  for (size_t t = 0; t < info.types.size(); ++t) {
    const int position = 1 + info.types[t].offsets[position_field];
    for (int slot = 0; slot < block.slots[t]; ++slot) {
      const float* const x = records + position * block_lanes;
      for (int lane = 0; lane < block_lanes; ++lane) {
        const vec3 p(x[lane], x[block_lanes + lane], x[2 * block_lanes + lane]);
        if (records[lane] > 0) bounds.extend(p);
      }
      records += (1 + info.types[t].width) * block_lanes;
    }
  }
}

}  // namespace

std::vector<Bounds> tile_bounds(const RelightCache& cache) {
  const auto tiles = cache.tiles();
  const BlockDecoder decoder(cache, InstructionSet::automatic);
  std::vector<Bounds> bounds(tiles.size());
  parallel_for(tiles.size(), 8, [&](size_t begin, size_t end) {
    std::vector<float> decoded;
    for (size_t t = begin; t < end; ++t) {
      for (int b = 0; b < tiles[t].block_count; ++b) {
        const PackedBlock block = cache.block(tiles[t], b);
        extend(bounds[t], cache.info(), block, decoder.floats(block, decoded));
      }
    }
  });
  return bounds;
}

bool may_miss(const KernelLight& light) {
  return is_spot(light.kind) || has_range(light.kind);
}

bool can_reach(const KernelLight& light, const Bounds& bounds) {
  if (!may_miss(light)) return true;
  const dvec3 center = 0.5 * (dvec3(bounds.low) + dvec3(bounds.high));
  const double radius = 0.5 * glm::distance(dvec3(bounds.low), dvec3(bounds.high));
  const dvec3 position(light.position[0], light.position[1], light.position[2]);
  const double distance = glm::distance(center, position);
  if (has_range(light.kind)) {
    const double reach = (1 + range_margin) / std::sqrt(double{light.inverse_range_squared});
    if (distance > reach + radius * (1 + range_margin)) return false;
  }
  if (!is_spot(light.kind)) return true;
  const dvec3 axis = -dvec3(light.to_light[0], light.to_light[1], light.to_light[2]);
  if (distance <= radius * (1 + angle_margin)) return true;
  const double cosine = glm::dot(center - position, axis) / distance;
  const double angle = std::acos(std::clamp(cosine, -1.0, 1.0));
  const double outer = std::acos(std::clamp(static_cast<double>(light.cos_outer), -1.0, 1.0));
  return angle <= outer + std::asin(radius / distance) + angle_margin;
}

}  // namespace relume
