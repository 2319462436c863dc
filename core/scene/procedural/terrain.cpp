#include "core/scene/procedural/terrain.h"

#include "core/base/random.h"
#include "core/scene/procedural/mesh_builder.h"

namespace relume {
namespace {

constexpr int ground_cells = 192;
/// Half width of the path as a fraction of the field's side.
constexpr float path_half_width = 0.028f;

float smooth_step(float t) {
  return t * t * t * (t * (6 * t - 15) + 10);
}

}  // namespace

Terrain::Terrain(float size, float hill_height, uint64_t seed)
    : size_(size), hill_height_(hill_height), seed_(seed) {}

float Terrain::noise(vec2 place, uint32_t channel) const {
  const auto value_at = [&](float x, float y) {
    const auto column = static_cast<uint32_t>(static_cast<int32_t>(x));
    const auto row = static_cast<uint32_t>(static_cast<int32_t>(y));
    const auto bits = philox({column, row, channel, static_cast<uint32_t>(RandomStream::scatter)},
                             {static_cast<uint32_t>(seed_), static_cast<uint32_t>(seed_ >> 32)});
    return unit_float(bits[0]);
  };
  // Far cells repeat, so that any finite place has a cell number.
  const vec2 cell = glm::floor(glm::mod(place, vec2(65536.0f)));
  const vec2 t = glm::mod(place, vec2(65536.0f)) - cell;
  const float u = smooth_step(t.x);
  const float v = smooth_step(t.y);
  const float low = value_at(cell.x, cell.y) * (1 - u) + value_at(cell.x + 1, cell.y) * u;
  const float high = value_at(cell.x, cell.y + 1) * (1 - u) + value_at(cell.x + 1, cell.y + 1) * u;
  return low * (1 - v) + high * v;
}

float Terrain::height(vec2 place) const {
  const vec2 wide = place / (0.28f * size_);
  const vec2 narrow = place / (0.09f * size_);
  const float sum = 0.8f * noise(wide + vec2(9.5f), 0) + 0.2f * noise(narrow + vec2(31.2f), 1);
  // Outside the field the ground falls away, so that the view ends at the field's last plants.
  const float reach = std::max(std::abs(place.x), std::abs(place.y));
  const float outside = std::max(0.0f, reach - 0.52f * size_);
  const float fall = 0.3f * outside * outside / (outside + 0.1f * size_);
  return hill_height_ * (2 * sum - 1) - fall;
}

vec3 Terrain::normal(vec2 place) const {
  const float step = 0.002f * size_;
  const float slope_x = height(place + vec2(step, 0)) - height(place - vec2(step, 0));
  const float slope_z = height(place + vec2(0, step)) - height(place - vec2(0, step));
  return normalize_or(vec3(-slope_x, 2 * step, -slope_z), vec3(0, 1, 0));
}

float Terrain::distance_from_path(vec2 place) const {
  const float along = place.y / size_;
  const float middle =
      size_ * (0.075f * std::sin(7.0f * along + 0.5f) + 0.03f * std::sin(15 * along));
  return std::abs(place.x - middle) / (path_half_width * size_);
}

Mesh Terrain::make_mesh(uint32_t material) const {
  MeshBuilder builder(material);
  const float side = 3 * size_;
  for (int row = 0; row <= ground_cells; ++row) {
    for (int column = 0; column <= ground_cells; ++column) {
      const vec2 uv(static_cast<float>(column) / static_cast<float>(ground_cells),
                    static_cast<float>(row) / static_cast<float>(ground_cells));
      const vec2 place = side * (uv - vec2(0.5f));
      builder.add_vertex({place.x, height(place), place.y}, normal(place), uv);
    }
  }
  for (uint32_t row = 0; row < ground_cells; ++row) {
    for (uint32_t column = 0; column < ground_cells; ++column) {
      const uint32_t a = row * (ground_cells + 1) + column;
      const uint32_t b = a + ground_cells + 1;
      builder.add_triangle(a, b, b + 1);
      builder.add_triangle(a, b + 1, a + 1);
    }
  }
  return builder.take();
}

}  // namespace relume
