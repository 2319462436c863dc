#include "core/image/view_table.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace relume {
namespace {

// A float's bits grow evenly within each octave, so that they cut it into cells of equal width.
constexpr float lowest = 0x1p-14f;  ///< 0.8 code values in sRGB
constexpr float highest = 64;
constexpr int cell_shift = 23 - 2;  ///< four cells an octave
constexpr int32_t cell_bits = 1 << cell_shift;
constexpr int32_t lowest_bits = std::bit_cast<int32_t>(lowest);
/// The first cell, from 0 to `lowest`, and those of the octaves.
constexpr int32_t cells = 1 + ((std::bit_cast<int32_t>(highest) - lowest_bits) >> cell_shift);
constexpr size_t side = cells + 1;

/// Where a channel stands: in a cell, at a fraction of it.
struct Place {
  int32_t cell = 0;
  float fraction = 0;  ///< in [0, 1]
};

Place find_place(float x) {
  const float clamped = std::min(std::max(0.0f, x), highest);  // max(0, NaN) is 0
  if (clamped < lowest) return {0, clamped / lowest};
  const int32_t above = std::bit_cast<int32_t>(clamped) - lowest_bits;
  const int32_t cell = std::min(1 + (above >> cell_shift), cells - 1);
  const int32_t rest = above - ((cell - 1) << cell_shift);
  return {cell, static_cast<float>(rest) / static_cast<float>(cell_bits)};
}

/// The reverse of find_place at the low end of cell `node`.
float node_value(size_t node) {
  if (node == 0) return 0;
  return std::bit_cast<float>(lowest_bits + ((static_cast<int32_t>(node) - 1) << cell_shift));
}

/// What a table can hold: transforms may give what is no number.
float finite_value(float value) {
  constexpr float largest = 16;  // times what a display can show
  return std::min(std::max(-largest, value), largest);
}

}  // namespace

ViewTable::ViewTable(const ColorTransform& transform) : nodes_(side * side * side) {
  parallel_for(side * side, 8, [&](size_t begin, size_t end) {
    std::array<float, 3 * side> row;
    for (size_t r = begin; r < end; ++r) {
      for (size_t i = 0; i < side; ++i) {
        row[3 * i] = node_value(i);
        row[3 * i + 1] = node_value(r % side);
        row[3 * i + 2] = node_value(r / side);
      }
      transform(row);
      for (size_t i = 0; i < side; ++i) {
        nodes_[r * side + i] = vec4(finite_value(row[3 * i]), finite_value(row[3 * i + 1]),
                                    finite_value(row[3 * i + 2]), 0);
      }
    }
  });
}

bool ViewTable::covers(const float* rgb) {
  return std::all_of(rgb, rgb + 3, [](float x) { return x >= 0 && x <= highest; });
}

void ViewTable::apply(std::span<float> rgb) const {
  CHECK_MSG(rgb.size() % 3 == 0, "{} values", rgb.size());
  constexpr int32_t red_step = 1;
  constexpr int32_t green_step = side;
  constexpr int32_t blue_step = side * side;
  constexpr int32_t all_steps = red_step + green_step + blue_step;
  for (size_t i = 0; i < rgb.size(); i += 3) {
    const Place r = find_place(rgb[i]);
    const Place g = find_place(rgb[i + 1]);
    const Place b = find_place(rgb[i + 2]);
    // The tetrahedron follows from the order of the fractions.
    const float high = std::max({r.fraction, g.fraction, b.fraction});
    const float low = std::min({r.fraction, g.fraction, b.fraction});
    const float middle = std::max(std::min(r.fraction, g.fraction),
                                  std::min(std::max(r.fraction, g.fraction), b.fraction));
    const bool red_is_high = r.fraction >= g.fraction && r.fraction >= b.fraction;
    const bool blue_is_low = b.fraction <= g.fraction && b.fraction <= r.fraction;
    const int32_t high_step = red_is_high                ? red_step
                              : g.fraction >= b.fraction ? green_step
                                                         : blue_step;
    const int32_t low_step = blue_is_low                ? blue_step
                             : g.fraction <= r.fraction ? green_step
                                                        : red_step;
    const vec4* node = &nodes_[r.cell * red_step + g.cell * green_step + b.cell * blue_step];
    const vec4 color = (1 - high) * node[0] + (high - middle) * node[high_step] +
                       (middle - low) * node[all_steps - low_step] + low * node[all_steps];
    std::copy_n(&color.x, 3, &rgb[i]);
  }
}

}  // namespace relume
