#include "core/image/display_transform.h"

#include <bit>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/image/color_config.h"
#include "core/math/color.h"

namespace relume {
namespace {

// A float's bits, cut to 10 bits of mantissa, index a table that spans the octaves in which the
// output changes. A cell is at most 0.11 code values wide, so a byte is within 0.56 of the exact
// value.
constexpr int mantissa_bits = 10;
constexpr int index_shift = 23 - mantissa_bits;
constexpr float lowest = 0x1p-14f;  ///< 0.2 code values in sRGB
constexpr float highest = 8.0f;     ///< filmic reaches 1 at 7.24
constexpr int32_t first_index = std::bit_cast<int32_t>(lowest) >> index_shift;
constexpr int32_t last_index = std::bit_cast<int32_t>(highest) >> index_shift;

using Table = std::array<uint8_t, last_index - first_index + 1>;

float eval_curve(ToneCurve curve, float x) {
  switch (curve) {
    case ToneCurve::srgb:
    case ToneCurve::config:  // has no formula
      return x;
    case ToneCurve::filmic:
      return x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f);
  }
  return x;
}

Table make_table(ToneCurve curve) {
  Table table;
  for (size_t i = 0; i < table.size(); ++i) {
    const int32_t bits = (first_index + static_cast<int32_t>(i)) << index_shift;
    const float center = std::bit_cast<float>(bits | (1 << (index_shift - 1)));
    const float display = srgb_from_linear(std::clamp(eval_curve(curve, center), 0.0f, 1.0f));
    table[i] = static_cast<uint8_t>(255.0f * display + 0.5f);
  }
  table.front() = 0;
  return table;
}

const Table& table_of(ToneCurve curve) {
  static const Table srgb = make_table(ToneCurve::srgb);
  static const Table filmic = make_table(ToneCurve::filmic);
  return curve == ToneCurve::filmic ? filmic : srgb;
}

/// Negative values, NaN and everything below `lowest` give 0; infinity gives the table's end.
uint8_t look_up(const Table& table, float x) {
  const float clamped = std::min(std::max(lowest, x), highest);  // max(lowest, NaN) is lowest
  return table[(std::bit_cast<int32_t>(clamped) >> index_shift) - first_index];
}

template <size_t out_channels>
void apply_curve(const Image& image, const DisplayTransform& transform, std::span<uint8_t> out) {
  const Table& table = table_of(transform.curve);
  const float scale = std::exp2(transform.exposure);
  const size_t in_channels = static_cast<size_t>(image.channels);
  parallel_for(image.pixel_count(), 16384, [&](size_t begin, size_t end) {
    const float* in = image.pixels.data() + begin * in_channels;
    uint8_t* bytes = out.data() + begin * out_channels;
    for (size_t pixel = begin; pixel < end; ++pixel) {
      bytes[0] = look_up(table, in[0] * scale);
      bytes[1] = look_up(table, in[1] * scale);
      bytes[2] = look_up(table, in[2] * scale);
      if constexpr (out_channels == 4) bytes[3] = 255;
      in += in_channels;
      bytes += out_channels;
    }
  });
}

constexpr size_t view_block = 512;  ///< pixels that stay in the cache

/// Display values of at most view_block triples, in place; those beyond the table one by one exact.
void apply_draft(const ConfigView& view, const ViewTable& table, std::span<float> rgb) {
  std::array<float, 3 * view_block> beyond;
  size_t count = 0;
  for (size_t i = 0; i < rgb.size(); i += 3) {
    if (ViewTable::covers(&rgb[i])) continue;
    std::copy_n(&rgb[i], 3, &beyond[count]);
    count += 3;
  }
  if (count == 0) return table.apply(rgb);
  view.apply(std::span(beyond).first(count));
  const float* exact = beyond.data();
  for (size_t i = 0; i < rgb.size(); i += 3) {
    if (ViewTable::covers(&rgb[i])) {
      table.apply(rgb.subspan(i, 3));
    } else {
      std::copy_n(exact, 3, &rgb[i]);
      exact += 3;
    }
  }
}

template <size_t out_channels>
void apply_config(const Image& image, const DisplayTransform& transform, DisplayQuality quality,
                  std::span<uint8_t> out) {
  const ConfigView& view = config_view();
  const ViewTable* table = quality == DisplayQuality::draft ? &view.table() : nullptr;
  const float scale = std::exp2(transform.exposure);
  parallel_for(image.pixel_count(), 4 * view_block, [&](size_t begin, size_t end) {
    std::array<float, 3 * view_block> values;
    for (size_t first = begin; first < end; first += view_block) {
      const size_t count = std::min(view_block, end - first);
      for (size_t i = 0; i < count; ++i) {
        const vec3 rgb = image.rgb(first + i) * scale;
        std::copy_n(&rgb.x, 3, &values[3 * i]);
      }
      const std::span<float> used = std::span(values).first(3 * count);
      table != nullptr ? apply_draft(view, *table, used) : view.apply(used);
      uint8_t* bytes = &out[out_channels * first];
      for (size_t i = 0; i < count; ++i, bytes += out_channels) {
        for (size_t c = 0; c < 3; ++c) bytes[c] = quantize_display(values[3 * i + c]);
        if constexpr (out_channels == 4) bytes[3] = 255;
      }
    }
  });
}

template <size_t out_channels>
void transform_pixels(const Image& image, const DisplayTransform& transform, DisplayQuality quality,
                      std::span<uint8_t> out) {
  CHECK_MSG(image.channels >= 3, "channels {}", image.channels);
  CHECK_MSG(out.size() == image.pixel_count() * out_channels, "{} bytes for {} pixels", out.size(),
            image.pixel_count());
  if (transform.curve == ToneCurve::config) {
    apply_config<out_channels>(image, transform, quality, out);
  } else {
    apply_curve<out_channels>(image, transform, out);
  }
}

}  // namespace

ToneCurve default_curve() {
  return has_color_config() ? ToneCurve::config : ToneCurve::srgb;
}

DisplayImage apply_display(const Image& image, const DisplayTransform& transform) {
  DisplayImage result{image.width, image.height, 3, {}};
  result.pixels.resize(image.pixel_count() * 3);
  transform_pixels<3>(image, transform, DisplayQuality::exact, result.pixels);
  return result;
}

void apply_display_rgba(const Image& image, const DisplayTransform& transform,
                        std::span<uint8_t> rgba, DisplayQuality quality) {
  transform_pixels<4>(image, transform, quality, rgba);
}

}  // namespace relume
