#include "core/scene/io/scatter.h"

#include <optional>
#include <unordered_map>

#include "core/base/check.h"
#include "core/base/random.h"

namespace relume {
namespace {

constexpr int max_tries = 256;

/// Points in square cells at least min_distance wide, so that a neighbour is at most one cell away.
class PointGrid {
 public:
  explicit PointGrid(const ScatterParams& params)
      : low_(params.low), min_distance_(params.min_distance) {
    const vec2 extent = params.high - params.low;
    cell_ = std::max({params.min_distance, extent.x / 65536.0f, extent.y / 65536.0f, 1e-30f});
  }

  bool is_free(vec2 p) const {
    const ivec2 cell = cell_of(p);
    for (int z = cell.y - 1; z <= cell.y + 1; ++z) {
      for (int x = cell.x - 1; x <= cell.x + 1; ++x) {
        const auto found = points_.find(key_of({x, z}));
        if (found == points_.end()) continue;
        for (const vec2 other : found->second) {
          if (glm::length(dvec2(other) - dvec2(p)) < min_distance_) return false;
        }
      }
    }
    return true;
  }

  void add(vec2 p) { points_[key_of(cell_of(p))].push_back(p); }

 private:
  ivec2 cell_of(vec2 p) const {
    const vec2 cell = glm::floor((p - low_) / cell_);
    return {static_cast<int>(cell.x), static_cast<int>(cell.y)};
  }
  static uint64_t key_of(ivec2 cell) {
    return uint64_t{static_cast<uint32_t>(cell.x)} << 32 | static_cast<uint32_t>(cell.y);
  }

  vec2 low_;
  float min_distance_;
  float cell_;
  std::unordered_map<uint64_t, std::vector<vec2>> points_;
};

std::optional<vec2> find_place(const ScatterParams& params, const PointGrid& grid, Random& random) {
  for (int i = 0; i < max_tries; ++i) {
    const float x = random.uniform(params.low.x, params.high.x);
    const float z = random.uniform(params.low.y, params.high.y);
    if (params.min_distance <= 0 || grid.is_free({x, z})) return vec2(x, z);
  }
  return std::nullopt;
}

mat4x3 make_placement(vec2 place, float height, float angle_rad, float scale) {
  const float c = std::cos(angle_rad) * scale;
  const float s = std::sin(angle_rad) * scale;
  return {vec3(c, 0, -s), vec3(0, scale, 0), vec3(s, 0, c), vec3(place.x, height, place.y)};
}

}  // namespace

std::vector<Placement> scatter(const ScatterParams& params) {
  CHECK(params.kinds > 0 && params.low.x <= params.high.x && params.low.y <= params.high.y);
  PointGrid grid(params);
  std::vector<Placement> placements;
  for (uint32_t i = 0; i < params.count; ++i) {
    Random random(params.seed, RandomStream::scatter, i);
    Placement placement;
    placement.kind = random.below(params.kinds);
    const float angle_rad = params.rotate ? random.uniform() * 2 * pi : 0;
    const float scale = random.uniform(params.scale_low, params.scale_high);
    const std::optional<vec2> place = find_place(params, grid, random);
    if (!place) break;
    if (params.min_distance > 0) grid.add(*place);
    placement.world_from_local = make_placement(*place, params.height, angle_rad, scale);
    placements.push_back(placement);
  }
  return placements;
}

}  // namespace relume
