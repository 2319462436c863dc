#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "core/base/label.h"
#include "core/scene/shader_info.h"

namespace relume {

/// How a cache stores records. Exact: 32-bit floats. Standard and compact: packed bits, some 20 and
/// 16 bytes a record; see docs/cache-format.md for their errors.
enum class CacheFormat : uint8_t { exact, standard, compact };

inline constexpr std::array cache_format_labels = {
    Label<CacheFormat>{CacheFormat::exact, "exact"},
    Label<CacheFormat>{CacheFormat::standard, "standard"},
    Label<CacheFormat>{CacheFormat::compact, "compact"},
};

/// How one field is stored. Decoders: core/samples/record_decode.h, encoder: record_encode.cpp.
enum class Codec : uint8_t {
  floats,      ///< as it is, a word a component
  view,        ///< a position as the eye sees it, see ViewAxes: steps within its block's box
  block_bias,  ///< nothing: the largest bias of its type in its block
  bias,        ///< a shadow-ray bias: two codes an octave, rounded up; 0 = 2^-100
  octahedral,  ///< a unit vector on the octahedron, unfolded to a square (Cigolle et al. 2014)
  range,       ///< a number within low..high, finer where it is small
  color,       ///< a colour times the record's weight: three 9-bit numbers with one 5-bit exponent
};

/// Where a field's bits are: component i is `bits[i]` bits from bit shift[i] of word[i] on.
struct PackedField {
  Codec codec = Codec::floats;
  int first = 0;  ///< float of the sample vector
  int width = 0;  ///< floats
  float low = 0;  ///< Codec::range
  float high = 0;
  std::array<int, 3> word{};
  std::array<int, 3> shift{};
  std::array<int, 3> bits{};
};

inline constexpr size_t max_record_fields = 16;
inline constexpr int max_record_words = 64;

/// One record of a shader as words of 32 bits. In the exact format word 0 is the weight; else
/// weights are part of the colours, and a record whose colours are all 0 is missing.
struct RecordLayout {
  CacheFormat format = CacheFormat::exact;
  int words = 0;
  int width = 0;  ///< floats of the sample vector
  int field_count = 0;
  std::array<PackedField, max_record_fields> fields{};
};

/// Scale of colours: 511 * 2^(31 - color_exponent_bias) is the largest, and 2^-color_exponent_bias
/// the step of dark ones.
inline constexpr int color_exponent_bias = 28;

/// Bias codes: code c stands for the float with the bits (c << 22) + bias_code_offset.
inline constexpr int32_t bias_code_offset = (127 - 100) << 23;

namespace layout_detail {

/// Takes bits word by word, first fit.
class BitAllocator {
 public:
  constexpr void take(PackedField& field, int component, int bits) {
    int word = 0;
    while (used_[word] + bits > 32) ++word;
    field.word[component] = word;
    field.shift[component] = used_[word];
    field.bits[component] = bits;
    used_[word] += bits;
    words_ = word + 1 > words_ ? word + 1 : words_;
  }
  constexpr int words() const { return words_; }

 private:
  std::array<int, max_record_words> used_{};
  int words_ = 0;
};

constexpr Codec codec_of(const SampleField& field, CacheFormat format) {
  if (format == CacheFormat::exact) return Codec::floats;
  if (field.source == FieldSource::position) return Codec::view;
  if (field.source == FieldSource::bias) {
    return format == CacheFormat::compact ? Codec::block_bias : Codec::bias;
  }
  const bool is_direction = field.kind == FieldKind::direction || field.kind == FieldKind::axis;
  if (is_direction && field.width == 3) return Codec::octahedral;
  if (field.kind == FieldKind::linear && field.width == 3) return Codec::color;
  if (field.kind == FieldKind::scalar && field.width == 1 && field.low >= 0 &&
      field.high > field.low) {
    return Codec::range;
  }
  return Codec::floats;
}

/// Bits of component i. `has_range`: the record has to hold a number as well.
constexpr int component_bits(Codec codec, int i, bool is_compact, bool has_range) {
  switch (codec) {
    case Codec::floats:
      return 32;
    case Codec::view:
      if (!is_compact) return 16;
      return has_range ? (i < 2 ? 12 : 14) : (i < 2 ? 11 : 22);
    case Codec::block_bias:
      return 0;
    case Codec::bias:
    case Codec::range:
      return 8;
    case Codec::octahedral:
      return i == 2 ? 0 : !is_compact ? 16 : has_range ? 9 : 10;
    case Codec::color:
      return i == 0 ? 32 : 0;
  }
  return 0;
}

}  // namespace layout_detail

/// The layout that a shader's declaration leads to. At most max_record_fields fields and 62 floats.
constexpr RecordLayout make_record_layout(std::span<const SampleField> fields, CacheFormat format) {
  using namespace layout_detail;  // NOLINT: of this function only
  RecordLayout layout;
  layout.format = format;
  bool has_range = false;
  for (const SampleField& field : fields) has_range |= codec_of(field, format) == Codec::range;
  BitAllocator bits;
  PackedField weight;
  if (format == CacheFormat::exact) bits.take(weight, 0, 32);
  for (const SampleField& field : fields) {
    PackedField& packed = layout.fields[layout.field_count++];
    packed.codec = codec_of(field, format);
    packed.first = layout.width;
    packed.width = field.width;
    packed.low = field.low;
    packed.high = field.high;
    for (int i = 0; i < field.width; ++i) {
      const int count = component_bits(packed.codec, i, format == CacheFormat::compact, has_range);
      if (count > 0) bits.take(packed, i, count);
    }
    layout.width += field.width;
  }
  layout.words = bits.words();
  return layout;
}

/// Codec::range: code c in 0..255 stands for low + v - 1, where v has the float's bits of 1 and c
/// such steps.
constexpr float range_step(const PackedField& field) {
  const auto bits = std::bit_cast<int32_t>(1 + (field.high - field.low));
  return static_cast<float>(bits - 0x3f800000) / 255.0f;
}

/// Floats of a block's frame: lowest u, v and depth, extent of each. One bias a type follows.
/// Packed formats only.
inline constexpr int block_frame_floats = 6;

/// What packed positions are relative to: p = eye + depth (forward + u right + v up). Pixels of a
/// block differ little in u and v, however far behind each other their records lie.
struct ViewAxes {
  float eye[3] = {};
  float forward[3] = {};
  float right[3] = {};
  float up[3] = {};
};

}  // namespace relume
