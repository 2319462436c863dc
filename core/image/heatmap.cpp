#include "core/image/heatmap.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/image/tiny_font.h"

namespace relume {
namespace {

constexpr float smallest_range = 1e-9f;

/// The map at multiples of 1/16.
constexpr std::array<std::array<float, 3>, 17> inferno_knots{{
    {0.0015f, 0.0005f, 0.0139f},
    {0.0423f, 0.0281f, 0.1411f},
    {0.1293f, 0.0473f, 0.2908f},
    {0.2383f, 0.0366f, 0.3964f},
    {0.3415f, 0.0623f, 0.4294f},
    {0.4412f, 0.0993f, 0.4316f},
    {0.5409f, 0.1347f, 0.4151f},
    {0.6401f, 0.1714f, 0.3811f},
    {0.7357f, 0.2159f, 0.3302f},
    {0.8224f, 0.2752f, 0.2661f},
    {0.8943f, 0.3534f, 0.1936f},
    {0.9470f, 0.4492f, 0.1153f},
    {0.9784f, 0.5579f, 0.0349f},
    {0.9879f, 0.6753f, 0.0653f},
    {0.9746f, 0.7977f, 0.2063f},
    {0.9476f, 0.9174f, 0.4107f},
    {0.9884f, 0.9984f, 0.6449f},
}};

/// Knot `i`; beyond the ends the first and last differences repeat.
vec3 knot(int i) {
  const auto at = [](size_t k) {
    return vec3(inferno_knots[k][0], inferno_knots[k][1], inferno_knots[k][2]);
  };
  const int last = static_cast<int>(inferno_knots.size()) - 1;
  if (i < 0) return 2.0f * at(0) - at(1);
  if (i > last) return 2.0f * at(inferno_knots.size() - 1) - at(inferno_knots.size() - 2);
  return at(static_cast<size_t>(i));
}

/// Catmull-Rom interpolation between b and c, t in [0, 1].
vec3 interpolate_knots(vec3 a, vec3 b, vec3 c, vec3 d, float t) {
  const vec3 linear = c - a;
  const vec3 quadratic = 2.0f * a - 5.0f * b + 4.0f * c - d;
  const vec3 cubic = 3.0f * (b - c) + d - a;
  return b + 0.5f * t * (linear + t * (quadratic + t * cubic));
}

using Rgb = std::array<uint8_t, 3>;

Rgb encode(vec3 color) {
  const vec3 scaled = 255.0f * color + vec3(0.5f);
  return {static_cast<uint8_t>(scaled.x), static_cast<uint8_t>(scaled.y),
          static_cast<uint8_t>(scaled.z)};
}

void put(DisplayImage& image, int x, int y, const Rgb& color) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  std::copy(color.begin(), color.end(),
            image.pixels.begin() + 3 * (static_cast<std::ptrdiff_t>(y) * image.width + x));
}

/// The map in bytes at multiples of 1/1023.
const std::array<Rgb, 1024>& encoded_map() {
  static const std::array<Rgb, 1024> map = [] {
    std::array<Rgb, 1024> entries;
    for (size_t i = 0; i < entries.size(); ++i) {
      entries[i] = encode(heat_color(static_cast<float>(i) / 1023.0f));
    }
    return entries;
  }();
  return map;
}

Rgb encoded_heat_color(float value) {
  if (std::isnan(value)) return encode(heat_color(value));
  return encoded_map()[static_cast<size_t>(1023.0f * std::clamp(value, 0.0f, 1.0f) + 0.5f)];
}

/// Sizes of the bar below the picture, in pixels.
struct BarLayout {
  explicit BarLayout(int image_width)
      : scale(image_width >= 400 ? 2 : 1), width(std::max(image_width, 48)), margin(4 * scale) {}

  int scale;  ///< pixels per dot of the font
  int width;
  int margin;
  int bar_height() const { return 8 * scale; }
  int tick_height() const { return 3 * scale; }
  int text_top() const { return margin + bar_height() + tick_height() + scale; }
  int height() const { return text_top() + tiny_font_height * scale + margin; }
  int bar_width() const { return width - 2 * margin; }
};

std::string tick_label(float value) {
  return fmt::format("{:.3g}", value);
}

/// As many equal intervals as keep neighbouring labels apart; a range that starts with 2 divides
/// nicely by 4, others by 5.
int tick_intervals(const BarLayout& layout, float range) {
  const double decade = std::pow(10.0, std::floor(std::log10(range) + 1e-6));
  const int nice = std::lround(range / decade) == 2 ? 4 : 5;
  for (const int intervals : {nice, 2}) {
    int label_width = 0;
    for (int i = 0; i <= intervals; ++i) {
      const float value = range * static_cast<float>(i) / static_cast<float>(intervals);
      label_width = std::max(label_width, tiny_text_width(tick_label(value)) * layout.scale);
    }
    // The outer labels may be pushed inwards by half their width.
    if (layout.bar_width() / intervals >= label_width * 3 / 2 + 3 * layout.scale) return intervals;
  }
  return 1;
}

void draw_label(DisplayImage& image, const std::string& text, int left, int top, int scale,
                const Rgb& color) {
  draw_tiny_text(text, [&](int x, int y) {
    for (int dy = 0; dy < scale; ++dy) {
      for (int dx = 0; dx < scale; ++dx) {
        put(image, left + x * scale + dx, top + y * scale + dy, color);
      }
    }
  });
}

void draw_scale_bar(DisplayImage& image, const BarLayout& layout, int top, float range) {
  constexpr Rgb ink{230, 230, 230};
  const int bar_width = layout.bar_width();
  for (int x = 0; x < bar_width; ++x) {
    const float value =
        bar_width > 1 ? static_cast<float>(x) / static_cast<float>(bar_width - 1) : 0;
    const Rgb color = encoded_heat_color(value);
    for (int y = 0; y < layout.bar_height(); ++y) {
      const bool edge = x == 0 || x == bar_width - 1 || y == 0 || y == layout.bar_height() - 1;
      put(image, layout.margin + x, top + layout.margin + y, edge ? ink : color);
    }
  }
  const int intervals = tick_intervals(layout, range);
  for (int i = 0; i <= intervals; ++i) {
    const int x = layout.margin + (bar_width - 1) * i / intervals;
    for (int y = 0; y < layout.tick_height(); ++y) {
      put(image, x, top + layout.margin + layout.bar_height() + y, ink);
    }
    const float value = range * static_cast<float>(i) / static_cast<float>(intervals);
    const std::string text = tick_label(value);
    const int text_width = tiny_text_width(text) * layout.scale;
    const int left = std::clamp(x - text_width / 2, 0, std::max(0, image.width - text_width));
    draw_label(image, text, left, top + layout.text_top(), layout.scale, ink);
  }
}

}  // namespace

vec3 heat_color(float value) {
  if (std::isnan(value)) return {1, 0, 1};
  const float x = 16.0f * std::clamp(value, 0.0f, 1.0f);
  const int i = std::min(static_cast<int>(x), 15);
  const vec3 color =
      interpolate_knots(knot(i - 1), knot(i), knot(i + 1), knot(i + 2), x - static_cast<float>(i));
  return glm::clamp(color, 0.0f, 1.0f);
}

float automatic_range(const Image& error) {
  CHECK_MSG(error.channels == 1, "channels {}", error.channels);
  std::vector<float> values;
  for (const float value : error.pixels) {
    if (value > 0 && is_finite(value)) values.push_back(value);
  }
  if (values.empty()) return smallest_range;
  const size_t rank = std::min(values.size() - 1, values.size() * 995 / 1000);
  const auto quantile = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), quantile, values.end());
  const double decade = std::pow(10.0, std::floor(std::log10(*quantile)));
  double range = 10 * decade;
  for (const double step : {5.0, 2.0, 1.0}) {
    if (static_cast<float>(step * decade) >= *quantile) range = step * decade;
  }
  constexpr double largest = std::numeric_limits<float>::max();
  return static_cast<float>(std::clamp<double>(range, smallest_range, largest));
}

DisplayImage render_heatmap(const Image& error, const HeatmapParams& params) {
  CHECK_MSG(error.channels == 1, "channels {}", error.channels);
  CHECK_MSG(params.range >= 0 && is_finite(params.range), "range {}", params.range);
  const float range =
      params.range > 0 ? std::max(params.range, smallest_range) : automatic_range(error);
  const BarLayout layout(error.width);
  DisplayImage result{error.width, error.height, 3, {}};
  if (params.scale_bar) {
    result.width = layout.width;
    result.height += layout.height();
  }
  result.pixels.assign(static_cast<size_t>(result.width) * result.height * 3, 0);
  parallel_for(static_cast<size_t>(error.height), 16, [&](size_t begin, size_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < error.width; ++x) {
        put(result, x, y, encoded_heat_color(*error.at(x, y) / range));
      }
    }
  });
  if (params.scale_bar) draw_scale_bar(result, layout, error.height, range);
  return result;
}

}  // namespace relume
