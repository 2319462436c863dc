#include "shadow/volume_grid.h"

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace relume {
namespace {

/// Cells that one task fills at a time, 28 bytes each.
constexpr uint64_t chunk_cells = 1'500'000;

/// Area and second moments of what lies in a cell.
struct CellSum {
  float area = 0;
  std::array<float, 6> moments{};
};

/// Layers [z0, z1) of the grid, being filled.
struct Chunk {
  const VolumeGrid& grid;
  int z0;
  int z1;
  std::vector<CellSum> cells;

  /// `p` in cells.
  void add(vec3 p, float area, const std::array<float, 6>& moments) {
    const int z = static_cast<int>(std::floor(p.z));
    if (z < z0 || z >= z1) return;
    const int x = static_cast<int>(std::floor(p.x));
    const int y = static_cast<int>(std::floor(p.y));
    if (x < 0 || y < 0 || x >= grid.size[0] || y >= grid.size[1]) return;
    CellSum& sum = cells[(static_cast<size_t>(z - z0) * grid.size[1] + y) * grid.size[0] + x];
    sum.area += area;
    for (size_t i = 0; i < moments.size(); ++i) sum.moments[i] += area * moments[i];
  }
};

std::array<float, 6> square(vec3 v) {
  return {v.x * v.x, v.y * v.y, v.z * v.z, v.x * v.y, v.x * v.z, v.y * v.z};
}

/// Pieces are laid down in steps of half a cell.
constexpr float steps_per_cell = 2;

void add_strand(const Strip& piece, vec3 p0, vec3 p1, float inverse_cell, Chunk& chunk) {
  const vec3 d = p1 - p0;
  const float length = glm::length(d);
  if (!(length > 0)) return;
  std::array<float, 6> moments = square(d / length);
  for (size_t i = 0; i < 6; ++i) moments[i] = (i < 3 ? 1.0f : 0.0f) - moments[i];
  const int steps = std::max(1, static_cast<int>(std::ceil(length * steps_per_cell)));
  const float step = 1 / static_cast<float>(steps);
  for (int i = 0; i < steps; ++i) {
    const float u = (static_cast<float>(i) + 0.5f) * step;
    const float width = 2 * (piece.r0 + (piece.r1 - piece.r0) * u) * inverse_cell;
    const float area = width * length * step;
    chunk.add(p0 + d * u, area * clumping(width, length), moments);
  }
}

void add_triangle(const Strip& piece, vec3 p0, vec3 p1, vec3 p2, Chunk& chunk) {
  const vec3 e1 = p1 - p0;
  const vec3 e2 = p2 - p0;
  const vec3 normal = glm::cross(e1, e2);
  const float length = glm::length(normal);
  if (!(length > 0)) return;
  const std::array<float, 6> moments = square(normal / length);
  const float longest = std::max({glm::length(e1), glm::length(e2), glm::length(p2 - p1)});
  const int steps = std::max(1, static_cast<int>(std::ceil(longest * steps_per_cell)));
  const float step = 1 / static_cast<float>(steps);
  const float clumped = clumping(length / longest, longest);
  const float area = 0.5f * length * piece.fill * step * step * clumped;
  // steps^2 equal triangles, upright and upside down.
  for (int i = 0; i < steps; ++i) {
    for (int j = 0; i + j < steps; ++j) {
      const float u = static_cast<float>(i) + 1 / 3.0f;
      const float v = static_cast<float>(j) + 1 / 3.0f;
      chunk.add(p0 + e1 * (u * step) + e2 * (v * step), area, moments);
      if (i + j + 1 == steps) continue;
      chunk.add(p0 + e1 * ((u + 1 / 3.0f) * step) + e2 * ((v + 1 / 3.0f) * step), area, moments);
    }
  }
}

void add_piece(const Strip& piece, float inverse_cell, Chunk& chunk) {
  const auto to_cells = [&](vec3 p) { return (p - chunk.grid.origin) * inverse_cell; };
  const vec3 p0 = to_cells(piece.p0);
  const vec3 p1 = to_cells(piece.p1);
  const auto low = static_cast<float>(chunk.z0);
  const auto high = static_cast<float>(chunk.z1);
  if (piece.is_strand()) {
    if (std::max(p0.z, p1.z) >= low && std::min(p0.z, p1.z) < high) {
      add_strand(piece, p0, p1, inverse_cell, chunk);
    }
    return;
  }
  const vec3 p2 = to_cells(piece.p2);
  if (std::max({p0.z, p1.z, p2.z}) < low || std::min({p0.z, p1.z, p2.z}) >= high) return;
  add_triangle(piece, p0, p1, p2, chunk);
}

/// What a chunk leaves in the grid.
struct ChunkCells {
  std::vector<uint32_t> occupied;
  std::vector<float> area;
  std::vector<std::array<int8_t, 6>> moments;
};

ChunkCells fill_chunk(const SceneStrips& thin, const VolumeGrid& grid, int z0, int z1) {
  Chunk chunk{grid, z0, z1, {}};
  const size_t layer = static_cast<size_t>(grid.size[0]) * grid.size[1];
  chunk.cells.resize(layer * (z1 - z0));
  const float inverse_cell = 1 / grid.cell;
  const float low = grid.origin.z + grid.cell * static_cast<float>(z0);
  const float high = grid.origin.z + grid.cell * static_cast<float>(z1);
  for (size_t i = 0; i < thin.instance_count(); ++i) {
    const Bounds& box = thin.instance_bounds(i);
    if (box.empty() || box.high.z < low || box.low.z > high) continue;
    thin.visit(i, [&](const Strip& piece) { add_piece(piece, inverse_cell, chunk); });
  }
  ChunkCells out;
  for (size_t i = 0; i < chunk.cells.size(); ++i) {
    const CellSum& sum = chunk.cells[i];
    if (!(sum.area > 0)) continue;
    out.occupied.push_back(static_cast<uint32_t>(layer * z0 + i));
    out.area.push_back(sum.area);
    std::array<int8_t, 6>& packed = out.moments.emplace_back();
    for (size_t m = 0; m < 6; ++m) {
      const float value = std::clamp(sum.moments[m] / sum.area, -1.0f, 1.0f);
      packed[m] = static_cast<int8_t>(std::lround(127 * value));
    }
  }
  return out;
}

/// The grid's place: the fewest cells a side that hold the box with a cell of margin.
VolumeGrid place_grid(const Bounds& box, float cell) {
  VolumeGrid grid;
  grid.cell = cell;
  for (int axis = 0; axis < 3; ++axis) {
    const float cells = (box.high[axis] - box.low[axis]) / cell + 2;
    const int wanted = static_cast<int>(std::ceil(cells));
    grid.size[axis] = (wanted + volume_alignment - 1) / volume_alignment * volume_alignment;
    const float extent = static_cast<float>(grid.size[axis]) * cell;
    grid.origin[axis] = 0.5f * (box.low[axis] + box.high[axis]) - 0.5f * extent;
  }
  return grid;
}

/// The smallest cells of which at most `limit` fit into the box.
VolumeGrid place_grid_within(const Bounds& box, uint64_t limit) {
  const dvec3 extent = glm::max(dvec3(box.high) - dvec3(box.low), dvec3(1e-6 * box.radius()));
  double cell = std::cbrt(extent.x * extent.y * extent.z / static_cast<double>(limit));
  for (;;) {
    const VolumeGrid grid = place_grid(box, static_cast<float>(cell));
    if (grid.cell_count() <= limit) return grid;
    cell *= 1.02;
  }
}

}  // namespace

float clumping(float width, float length) {
  const float filled = width / (width + 1) * (length / (length + 1));
  return filled > 1e-4f ? -std::log1p(-filled) / filled : 1.0f;
}

size_t VolumeGrid::memory_bytes() const {
  return occupied.size() * (sizeof(uint32_t) + sizeof(float) + sizeof(moments[0]));
}

VolumeGrid make_volume_grid(const SceneStrips& thin, const VolumeParams& params,
                            const Bounds& region) {
  const Bounds box = region.empty() ? thin.bounds() : region;
  CHECK_MSG(params.max_cells >= 65536 && params.max_cells < uint64_t{1} << 31, "max_cells {}",
            params.max_cells);
  if (thin.empty() || !(box.radius() > 0)) return {};
  bool has_leaves = false;
  for (size_t i = 0; i < thin.instance_count(); ++i) has_leaves |= thin.has_triangles(i);
  const uint64_t most =
      has_leaves ? params.max_cells : std::min(params.max_cells, params.max_strand_cells);
  for (uint64_t limit = most;; limit = limit * 2 / 3) {
    VolumeGrid grid = place_grid_within(box, limit);
    const uint64_t layer = uint64_t{1} * grid.size[0] * grid.size[1];
    const int layers = static_cast<int>(std::max<uint64_t>(1, chunk_cells / layer));
    const int chunk_count = (grid.size[2] + layers - 1) / layers;
    std::vector<ChunkCells> chunks(chunk_count);
    parallel_for(chunks.size(), 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        const int z0 = static_cast<int>(i) * layers;
        chunks[i] = fill_chunk(thin, grid, z0, std::min(grid.size[2], z0 + layers));
      }
    });
    uint64_t occupied = 0;
    for (const ChunkCells& chunk : chunks) occupied += chunk.occupied.size();
    if (occupied > params.max_occupied && limit > 65536) continue;
    for (ChunkCells& chunk : chunks) {
      grid.occupied.insert(grid.occupied.end(), chunk.occupied.begin(), chunk.occupied.end());
      grid.area.insert(grid.area.end(), chunk.area.begin(), chunk.area.end());
      grid.moments.insert(grid.moments.end(), chunk.moments.begin(), chunk.moments.end());
      chunk = {};
    }
    return grid;
  }
}

}  // namespace relume
