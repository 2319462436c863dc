#include "shadow/volume.h"

#include "core/base/parallel.h"

namespace relume {
namespace {

constexpr float full = 65535.0f;

/// Cells that one thread fills at a time.
constexpr size_t fill_grain = 16384;

/// Where a cell lies.
struct CellPlace {
  uint32_t x;
  uint32_t y;
  uint32_t z;
};

CellPlace place_of(uint32_t cell, const std::array<int, 3>& size) {
  const auto width = static_cast<uint32_t>(size[0]);
  const auto height = static_cast<uint32_t>(size[1]);
  const uint32_t row = cell / width;
  return {cell - row * width, row % height, row / height};
}

/// The way from a cell's centre to the light, of any length; `light` in cells of the level, or the
/// direction of a parallel one.
vec3 way_to_light(CellPlace cell, vec3 light, bool parallel) {
  if (parallel) return light;
  return light - vec3(cell.x, cell.y, cell.z) - 0.5f;
}

int longest_axis(vec3 w) {
  const vec3 a = glm::abs(w);
  return a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
}

/// What a cell of the finest level stops of light that comes along `way`.
float cell_coverage(const VolumeGrid& grid, size_t i, vec3 way) {
  const std::array<int8_t, 6>& q = grid.moments[i];
  const float form =
      static_cast<float>(q[0]) * way.x * way.x + static_cast<float>(q[1]) * way.y * way.y +
      static_cast<float>(q[2]) * way.z * way.z +
      2 * (static_cast<float>(q[3]) * way.x * way.y + static_cast<float>(q[4]) * way.x * way.z +
           static_cast<float>(q[5]) * way.y * way.z);
  const float across = std::max(max_abs_component(way), 1e-20f);
  const float seen = grid.area[i] * std::sqrt(std::max(form, 0.0f) / 127) / across;
  const float open = 1 - 0.5f * std::min(seen, 2.0f);
  return 1 - open * open;
}

}  // namespace

VolumeVisibility::VolumeVisibility(const Scene& scene, const std::vector<Bounds>& boxes,
                                   const VolumeParams& params, const Bounds& region)
    : params_(params),
      kernels_(best_lookup_kernels()),
      grid_(make_volume_grid(SceneStrips(scene), params, region)),
      solids_(SceneStrips(scene), boxes) {
  make_levels();
}

void VolumeVisibility::make_levels() {
  for (size_t l = 0; l < levels_.size(); ++l) {
    Level& level = levels_[l];
    uint64_t cells = 1;
    for (int axis = 0; axis < 3; ++axis) {
      level.size[axis] = grid_.size[axis] >> l;
      cells *= level.size[axis];
      lookup_.size[axis] = grid_.size[axis];
      lookup_.origin[axis] = grid_.origin[axis];
    }
    level.coverage.assign(cells + 1, 0);
    lookup_.coverage[l] = level.coverage.data();
    if (l == 0) continue;
    const Level& finer = levels_[l - 1];
    std::vector<bool> marked(cells, false);
    for (const uint32_t cell : l == 1 ? grid_.occupied : finer.occupied) {
      const CellPlace p = place_of(cell, finer.size);
      marked[(size_t{p.z / 2} * level.size[1] + p.y / 2) * level.size[0] + p.x / 2] = true;
    }
    for (size_t i = 0; i < cells; ++i) {
      if (marked[i]) level.occupied.push_back(static_cast<uint32_t>(i));
    }
  }
  lookup_.inverse_cell = 1 / grid_.cell;
  lookup_.gap = params_.gap;
  lookup_.steps = params_.steps;
}

uint64_t VolumeVisibility::memory_bytes() const {
  uint64_t bytes = grid_.memory_bytes() + solids_.memory_bytes();
  for (const Level& level : levels_) {
    bytes += level.occupied.size() * sizeof(uint32_t) + level.coverage.size() * sizeof(uint16_t);
  }
  return bytes;
}

void VolumeVisibility::prepare(const Light& light) {
  light_ = light;
  to_light_ = -normalize_or(light.direction, vec3(0, -1, 0));
  cos_outer_ = std::cos(radians_from_degrees(light.outer_angle_deg));
  solids_.prepare(light);
  lookup_.parallel = light.type == LightType::directional;
  for (int axis = 0; axis < 3; ++axis) {
    lookup_.light[axis] = lookup_.parallel ? to_light_[axis] : light.position[axis];
  }
  if (grid_.occupied.empty()) return;
  fill_finest();
  for (size_t level = 1; level < levels_.size(); ++level) fill_coarser(static_cast<int>(level));
}

void VolumeVisibility::fill_finest() {
  Level& level = levels_[0];
  const bool parallel = lookup_.parallel;
  const vec3 light = parallel ? to_light_ : (light_.position - grid_.origin) / grid_.cell;
  parallel_for(grid_.occupied.size(), fill_grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const uint32_t cell = grid_.occupied[i];
      const vec3 way = way_to_light(place_of(cell, level.size), light, parallel);
      level.coverage[cell] = static_cast<uint16_t>(full * cell_coverage(grid_, i, way) + 0.5f);
    }
  });
}

void VolumeVisibility::fill_coarser(int l) {
  Level& level = levels_[l];
  const Level& finer = levels_[l - 1];
  const bool parallel = lookup_.parallel;
  const float cell_size = grid_.cell * static_cast<float>(1 << l);
  const vec3 light = parallel ? to_light_ : (light_.position - grid_.origin) / cell_size;
  const size_t stride[3] = {1, static_cast<size_t>(finer.size[0]),
                            static_cast<size_t>(finer.size[0]) * finer.size[1]};
  parallel_for(level.occupied.size(), fill_grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const uint32_t cell = level.occupied[i];
      const CellPlace p = place_of(cell, level.size);
      const int axis = longest_axis(way_to_light(p, light, parallel));
      const size_t main = stride[axis];
      const size_t u = stride[(axis + 1) % 3];
      const size_t v = stride[(axis + 2) % 3];
      const uint16_t* c = &finer.coverage[2 * (p.x + p.y * stride[1] + p.z * stride[2])];
      // Four columns of two cells: light passes both cells of a column.
      float open = 0;
      for (const size_t offset : {size_t{0}, u, v, u + v}) {
        open +=
            (full - static_cast<float>(c[offset])) * (full - static_cast<float>(c[offset + main]));
      }
      level.coverage[cell] = static_cast<uint16_t>(full - open / (4 * full) + 0.5f);
    }
  });
}

void VolumeVisibility::visibility(const Receivers& receivers, float* visibility) const {
  LookupChunk chunk;
  for (int first = 0; first < receivers.count; first += lookup_lanes) {
    chunk.load(receivers, first);
    chunk.mark_lit(light_, to_light_, cos_outer_);
    if (chunk.any_lit) {
      if (!grid_.occupied.empty()) {
        kernels_.march_volume(lookup_, chunk.receivers(), chunk.passed);
      }
      solids_.apply(chunk);
    }
    chunk.store(visibility);
  }
}

}  // namespace relume
