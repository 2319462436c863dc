#pragma once

// Packed bits to sample vectors: the one decoder, for kernels, shadow queries and the double
// reference. Part of the kernel sources: see core/simd/pack.h for what may be called here. Whatever
// the bits are, positions lie within the block's frame, directions are unit and all numbers are
// finite (Codec::floats aside). Instruction sets decode alike but for the last bits of positions
// and directions.

#include "core/samples/record_layout.h"
#include "core/simd/pack.h"

namespace relume::RELUME_ISA {

using F = Pack<native_width>;
using V = Vec3<F>;
using I = Lanes<int32_t, native_width>::type;

inline I load_word(const uint32_t* p) {
  I word;
  __builtin_memcpy(&word, p, sizeof(word));
  return word;
}

inline F take_bits(I word, int shift, int bits) {
  return to_float<native_width>((word >> shift) & ((1 << bits) - 1));
}

/// Unit vector of a point in [-1, 1]^2.
inline V unfold_octahedron(F u, F v) {
  const I sign = I{} + static_cast<int32_t>(0x80000000u);
  const auto magnitude = [sign](F x) { return from_bits<native_width>(bits_of(x) & ~sign); };
  const F z = F(1) - magnitude(u) - magnitude(v);
  const F fold = max(F(0) - z, F(0));
  const auto folded = [sign, fold](F x) {
    return x - from_bits<native_width>(bits_of(fold) | (bits_of(x) & sign));
  };
  const V d{folded(u), folded(v), z};
  return d * rsqrt(dot(d, d));
}

/// ViewAxes for all lanes.
struct ViewPack {
  V eye;
  V forward;
  V right;
  V up;
};

inline ViewPack broadcast(const ViewAxes& axes) {
  const auto vector = [](const float* p) { return V{F(p[0]), F(p[1]), F(p[2])}; };
  return {vector(axes.eye), vector(axes.forward), vector(axes.right), vector(axes.up)};
}

/// What a block's packed records are relative to.
struct DecodeFrame {
  const float* box;  ///< see block_frame_floats
  float bias;        ///< of the type
  const ViewPack& view;
};

/// Decodes field `field` of the records in a slot at `words`, from lane `lane` on, to
/// out[0, width). Words of a slot lie 16 apart.
[[gnu::always_inline]] inline void decode_field(const PackedField& field, const uint32_t* words,
                                                const DecodeFrame& frame, F* out) {
  constexpr int lanes = 16;
  const auto word = [&](int i) { return load_word(words + field.word[i] * lanes); };
  const auto number = [&](int i) { return take_bits(word(i), field.shift[i], field.bits[i]); };
  switch (field.codec) {
    case Codec::floats:
      for (int i = 0; i < field.width; ++i) out[i] = from_bits<native_width>(word(i));
      return;
    case Codec::view: {
      const auto axis = [&](int i) {
        const float steps = static_cast<float>((1 << field.bits[i]) - 1);
        return F(frame.box[i]) + number(i) * F(frame.box[3 + i] * (1.0f / steps));
      };
      const ViewPack& view = frame.view;
      const F u = axis(0);
      const F v = axis(1);
      const F depth = axis(2);
      out[0] = fma(depth, fma(v, view.up.x, fma(u, view.right.x, view.forward.x)), view.eye.x);
      out[1] = fma(depth, fma(v, view.up.y, fma(u, view.right.y, view.forward.y)), view.eye.y);
      out[2] = fma(depth, fma(v, view.up.z, fma(u, view.right.z, view.forward.z)), view.eye.z);
      return;
    }
    case Codec::block_bias:
      out[0] = F(frame.bias);
      return;
    case Codec::bias: {
      const I code = (word(0) >> field.shift[0]) & 255;
      out[0] = from_bits<native_width>((code << 22) + bias_code_offset);
      return;
    }
    case Codec::octahedral: {
      const F scale(2.0f / static_cast<float>((1 << field.bits[0]) - 1));
      const V d = unfold_octahedron(number(0) * scale - F(1), number(1) * scale - F(1));
      out[0] = d.x;
      out[1] = d.y;
      out[2] = d.z;
      return;
    }
    case Codec::range: {
      const F bits = number(0) * F(range_step(field)) + F(0x3f800000);
      out[0] = from_bits<native_width>(to_int(bits)) + F(field.low - 1);
      return;
    }
    case Codec::color: {
      const I bits = word(0);
      const I exponent = ((bits >> 27) & 31) + (127 - color_exponent_bias);
      const F scale = from_bits<native_width>(exponent << 23);
      for (int i = 0; i < 3; ++i) out[i] = take_bits(bits, 9 * i, 9) * scale;
      return;
    }
  }
}

}  // namespace relume::RELUME_ISA
