#include "core/samples/record_encode.h"

#include <cmath>

#include "core/base/check.h"

namespace relume {
namespace {

RareEvent clamped_colors("packed colours above 4088");

uint32_t round_to(double x, uint32_t largest) {
  return static_cast<uint32_t>(std::clamp(std::floor(x + 0.5), 0.0, static_cast<double>(largest)));
}

dvec3 vector_of(const float (&v)[3]) {
  return {v[0], v[1], v[2]};
}

/// u, v and depth of a position.
dvec3 to_view(const ViewAxes& axes, vec3 position) {
  const dvec3 d = dvec3(position) - vector_of(axes.eye);
  const double depth = std::max(glm::dot(d, vector_of(axes.forward)), 1e-20);
  return {glm::dot(d, vector_of(axes.right)) / depth, glm::dot(d, vector_of(axes.up)) / depth,
          depth};
}

double step_of(const PackedField& field, const BlockFrame& frame, int i) {
  return static_cast<double>(frame[3 + i]) / ((1 << field.bits[i]) - 1);
}

uvec3 view_code(const PackedField& field, const ViewAxes& axes, const BlockFrame& frame,
                vec3 position) {
  const dvec3 place = to_view(axes, position);
  uvec3 code(0);
  for (int i = 0; i < 3; ++i) {
    const double step = step_of(field, frame, i);
    if (step > 0) code[i] = round_to((place[i] - frame[i]) / step, (1u << field.bits[i]) - 1);
  }
  return code;
}

/// How far the decoded position is from `position`.
double rounding_error(const PackedField& field, const ViewAxes& axes, const BlockFrame& frame,
                      vec3 position) {
  const uvec3 code = view_code(field, axes, frame, position);
  dvec3 place;
  for (int i = 0; i < 3; ++i) place[i] = frame[i] + code[i] * step_of(field, frame, i);
  const dvec3 decoded =
      vector_of(axes.eye) + place.z * (vector_of(axes.forward) + place.x * vector_of(axes.right) +
                                       place.y * vector_of(axes.up));
  return glm::distance(decoded, dvec3(position));
}

uint32_t encode_bias(float bias) {
  const auto bits = static_cast<int64_t>(std::bit_cast<int32_t>(std::max(bias, 0.0f)));
  const int64_t code = (bits - bias_code_offset + (1 << 22) - 1) >> 22;  // upwards
  return static_cast<uint32_t>(std::clamp<int64_t>(code, 0, 255));
}

uint32_t encode_range(const PackedField& field, float value) {
  const float offset = std::clamp(value, field.low, field.high) - field.low;
  const auto steps = static_cast<double>(std::bit_cast<int32_t>(1 + offset) - 0x3f800000);
  return round_to(steps / static_cast<double>(range_step(field)), 255);
}

uint32_t encode_color(dvec3 color) {
  const double largest = std::ldexp(511.0, 31 - color_exponent_bias);
  double brightest = 0;
  for (size_t c = 0; c < 3; ++c) {
    if (color[c] > largest) clamped_colors.add();
    color[c] = std::clamp(color[c], 0.0, largest);
    brightest = std::max(brightest, color[c]);
  }
  if (!(brightest > 0)) return 0;
  int exponent = std::max(0, std::ilogb(brightest) + color_exponent_bias - 8);
  // The brightest may round up to 512 steps.
  if (std::ldexp(brightest, color_exponent_bias - exponent) >= 511.5) ++exponent;
  uint32_t word = static_cast<uint32_t>(exponent) << 27;
  for (int c = 0; c < 3; ++c) {
    word |= round_to(std::ldexp(color[c], color_exponent_bias - exponent), 511) << (9 * c);
  }
  return word;
}

}  // namespace

vec2 fold_octahedron(vec3 direction) {
  const vec3 d = normalize_or(direction, {0, 0, 1});
  const vec2 p = vec2(d.x, d.y) / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
  if (d.z >= 0) return p;
  return {(1 - std::abs(p.y)) * (p.x < 0 ? -1.0f : 1.0f),
          (1 - std::abs(p.x)) * (p.y < 0 ? -1.0f : 1.0f)};
}

ViewAxes make_view_axes(const Camera& camera) {
  const vec3 forward = normalize_or(camera.target - camera.eye, {0, 0, -1});
  const vec3 any = std::abs(forward.x) < 0.5f ? vec3(1, 0, 0) : vec3(0, 1, 0);
  const vec3 right =
      normalize_or(glm::cross(forward, normalize_or(camera.up, any)), glm::cross(forward, any));
  const vec3 up = glm::cross(right, forward);
  ViewAxes axes;
  for (int i = 0; i < 3; ++i) {
    axes.eye[i] = camera.eye[i];
    axes.forward[i] = forward[i];
    axes.right[i] = right[i];
    axes.up[i] = up[i];
  }
  return axes;
}

BlockFrame make_block_frame(const ViewAxes& axes, std::span<const vec3> positions) {
  BlockFrame frame{};
  if (positions.empty()) return frame;
  Bounds box;
  for (const vec3 position : positions) box.extend(vec3(to_view(axes, position)));
  for (int i = 0; i < 3; ++i) {
    frame[i] = box.low[i];
    frame[3 + i] = box.high[i] - box.low[i];
  }
  return frame;
}

float packed_bias(const RecordLayout& layout, const BlockFrame& frame, const ViewAxes& axes,
                  vec3 position, float bias) {
  const double moved = rounding_error(layout.fields[position_field], axes, frame, position);
  return bias + static_cast<float>(2 * moved);
}

void encode_record(const RecordLayout& layout, const float* values, float weight,
                   const BlockFrame& frame, const ViewAxes& axes, uint32_t* words) {
  std::fill_n(words, layout.words, 0u);
  const vec3 position(values[0], values[1], values[2]);
  for (int f = 0; f < layout.field_count; ++f) {
    const PackedField& field = layout.fields[f];
    const float* v = values + field.first;
    const auto put = [&](int i, uint32_t bits) { words[field.word[i]] |= bits << field.shift[i]; };
    switch (field.codec) {
      case Codec::floats:
        for (int i = 0; i < field.width; ++i) put(i, std::bit_cast<uint32_t>(v[i]));
        break;
      case Codec::view: {
        const uvec3 code = view_code(field, axes, frame, position);
        for (int i = 0; i < 3; ++i) put(i, code[i]);
        break;
      }
      case Codec::block_bias:
        break;
      case Codec::bias:
        put(0, encode_bias(packed_bias(layout, frame, axes, position, v[0])));
        break;
      case Codec::octahedral: {
        const vec2 p = fold_octahedron({v[0], v[1], v[2]});
        const uint32_t largest = (1u << field.bits[0]) - 1;
        for (int i = 0; i < 2; ++i) {
          put(i, round_to((static_cast<double>(p[i]) + 1) / 2 * largest, largest));
        }
        break;
      }
      case Codec::range:
        put(0, encode_range(field, v[0]));
        break;
      case Codec::color:
        put(0, encode_color(dvec3(v[0], v[1], v[2]) * static_cast<double>(weight)));
        break;
    }
  }
}

}  // namespace relume
