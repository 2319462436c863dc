#include "core/trace/texture_lookup.h"

#include "core/base/check.h"
#include "core/math/color.h"

namespace relume {
namespace {

/// Linear value of each 8-bit code.
const std::array<float, 256>& srgb_table() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values{};
    for (int i = 0; i < 256; ++i) values[i] = linear_from_srgb(static_cast<float>(i) / 255.0f);
    return values;
  }();
  return table;
}

vec4 texel(const Texture& texture, int x, int y) {
  const uint8_t* p = &texture.texels[(static_cast<size_t>(y) * texture.width + x) * 4];
  const float alpha = static_cast<float>(p[3]) / 255.0f;
  if (texture.srgb) {
    const std::array<float, 256>& table = srgb_table();
    return {table[p[0]], table[p[1]], table[p[2]], alpha};
  }
  return vec4(vec3(p[0], p[1], p[2]) / 255.0f, alpha);
}

int wrap(int i, int n) {
  const int r = i % n;
  return r < 0 ? r + n : r;
}

}  // namespace

vec4 lookup_texture(const Texture& texture, vec2 uv) {
  CHECK(texture.width > 0 && texture.height > 0);
  if (!is_finite(uv) || std::abs(uv.x) > 1e6f || std::abs(uv.y) > 1e6f) uv = vec2(0);
  const vec2 wrapped = uv - glm::floor(uv);
  const float x = wrapped.x * static_cast<float>(texture.width) - 0.5f;
  const float y = (1.0f - wrapped.y) * static_cast<float>(texture.height) - 0.5f;
  const float fx = std::floor(x);
  const float fy = std::floor(y);
  const int x0 = wrap(static_cast<int>(fx), texture.width);
  const int y0 = wrap(static_cast<int>(fy), texture.height);
  const int x1 = wrap(x0 + 1, texture.width);
  const int y1 = wrap(y0 + 1, texture.height);
  const vec4 top = glm::mix(texel(texture, x0, y0), texel(texture, x1, y0), x - fx);
  const vec4 bottom = glm::mix(texel(texture, x0, y1), texel(texture, x1, y1), x - fx);
  return glm::mix(top, bottom, y - fy);
}

}  // namespace relume
