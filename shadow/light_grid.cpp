#include "shadow/light_grid.h"

#include "core/base/parallel.h"

namespace relume {
namespace {

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

/// Lights so many cells away are taken as parallel.
constexpr float parallel_distance = 1e6f;

/// Rows of a slab that one thread sweeps, at least.
constexpr size_t rows_per_thread = 32;

}  // namespace

void LightGrid::sweep(const Light& light) {
  light_ = (light.position - grid_.origin) / grid_.cell;
  parallel_ = light.type == LightType::directional;
  if (parallel_) light_ = -normalize_or(light.direction, vec3(0, -1, 0));
  if (max_abs_component(light_) > parallel_distance) {
    parallel_ = true;
    light_ = normalize_or(light_, vec3(0, 1, 0));
  }
  if (grid_.occupied.empty()) return;
  fill_cells();
  for (const Slab& slab : order_slabs()) sweep_slab(slab);
}

void LightGrid::fill_cells() {
  cells_.resize(grid_.cell_count());
  parallel_for(cells_.size(), 1 << 18, [&](size_t begin, size_t end) {
    std::fill(cells_.begin() + static_cast<std::ptrdiff_t>(begin),
              cells_.begin() + static_cast<std::ptrdiff_t>(end), 1.0f);
  });
  parallel_for(grid_.occupied.size(), fill_grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const uint32_t cell = grid_.occupied[i];
      const vec3 way = way_to_light(place_of(cell, grid_.size), light_, parallel_);
      cells_[cell] = 1 - cell_coverage(grid_, i, way);
    }
  });
}

std::vector<LightGrid::Slab> LightGrid::order_slabs() const {
  std::vector<Slab> slabs;
  if (parallel_) {
    const int axis = longest_axis(light_);
    const int size = grid_.size[axis];
    const bool from_above = light_[axis] > 0;
    for (int i = 1; i < size; ++i) {
      const int place = from_above ? size - 1 - i : i;
      slabs.push_back({axis, place, from_above ? place + 1 : place - 1, static_cast<float>(i)});
    }
    return slabs;
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (int place = 0; place < grid_.size[axis]; ++place) {
      const float offset = static_cast<float>(place) + 0.5f - light_[axis];
      const int before = offset > 0 ? place - 1 : place + 1;
      const float distance = std::abs(offset);
      // Cells beside the light see it, and so does the grid's edge on the light's side.
      if (distance < 1 || before < 0 || before >= grid_.size[axis]) continue;
      slabs.push_back({axis, place, before, distance});
    }
  }
  std::ranges::stable_sort(slabs, {}, &Slab::distance);
  return slabs;
}

void LightGrid::sweep_slab(const Slab& slab) {
  const int stride[3] = {1, grid_.size[0], grid_.size[0] * grid_.size[1]};
  // Rows run along x where they can.
  const int u = slab.axis == 0 ? 1 : 0;
  const int v = 3 - slab.axis - u;
  struct Side {
    int begin, end;  ///< cells of the slab that belong to its axis
    int low, high;   ///< cells before them that are known
    float start, slope;
  };
  const auto side_of = [&](int axis) {
    const int size = grid_.size[axis];
    if (parallel_) return Side{0, size, 0, size - 1, light_[axis] / std::abs(light_[slab.axis]), 1};
    const float middle = light_[axis] - 0.5f;
    const auto first_at = [&](float x) {
      return static_cast<int>(std::ceil(std::clamp(x, 0.0f, static_cast<float>(size))));
    };
    // Cells as far off along two axes belong to the first of them.
    const auto belongs = [&](int cell) {
      const float distance = std::abs(static_cast<float>(cell) + 0.5f - light_[axis]);
      return axis < slab.axis ? distance < slab.distance : distance <= slab.distance;
    };
    Side side{
        first_at(middle - slab.distance - 1), first_at(middle + slab.distance + 1), 0, 0, 0, 0};
    while (side.begin < side.end && !belongs(side.begin)) ++side.begin;
    while (side.begin < side.end && !belongs(side.end - 1)) --side.end;
    side.low = first_at(middle - slab.distance + 1);
    side.high = std::min(first_at(std::floor(middle + slab.distance)), size) - 1;
    side.slope = 1 - 1 / slab.distance;
    side.start = middle / slab.distance;
    return side;
  };
  const Side across = side_of(u);
  const Side rows = side_of(v);
  if (across.begin >= across.end || rows.begin >= rows.end) return;
  if (across.low > across.high || rows.low > rows.high) return;
  const auto count = static_cast<size_t>(rows.end - rows.begin);
  parallel_for(count, rows_per_thread, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const int j = rows.begin + static_cast<int>(i);
      const float from = std::clamp(rows.start + rows.slope * static_cast<float>(j),
                                    static_cast<float>(rows.low), static_cast<float>(rows.high));
      const int near = static_cast<int>(from);
      const int far = std::min(near + 1, rows.high);
      const int base = slab.before * stride[slab.axis];
      kernels_.sweep_row(cells_.data(), {slab.place * stride[slab.axis] + j * stride[v],
                                         stride[u],
                                         across.begin,
                                         across.end,
                                         {base + near * stride[v], base + far * stride[v]},
                                         from - static_cast<float>(near),
                                         across.start,
                                         across.slope,
                                         across.low,
                                         across.high});
    }
  });
}

LightGridLookup LightGrid::lookup(float gap) const {
  LightGridLookup lookup{};
  lookup.cells = cells_.data();
  for (int axis = 0; axis < 3; ++axis) {
    lookup.size[axis] = grid_.size[axis];
    lookup.origin[axis] = grid_.origin[axis];
    lookup.light[axis] = light_[axis];
  }
  lookup.inverse_cell = 1 / grid_.cell;
  lookup.parallel = parallel_;
  lookup.gap = gap;
  return lookup;
}

}  // namespace relume
