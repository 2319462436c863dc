#include "shadow/depth_map.h"

#include <atomic>

#include "core/base/parallel.h"

namespace relume {
namespace {

using Projection = LightPlane::Projection;

/// Strands wider than so many texels are drawn as two triangles.
constexpr float widest_line = 3;

/// The part of the segment that is at least `near` deep; false when none is.
bool clip_near(float near, vec3& a, vec3& b, float& radius_a, float& radius_b) {
  if (a.z < near && b.z < near) return false;
  const auto cut = [near](vec3& out, float& radius_out, vec3 in, float radius_in) {
    const float t = (near - out.z) / (in.z - out.z);
    out += t * (in - out);
    out.z = near;
    radius_out += t * (radius_in - radius_out);
  };
  if (a.z < near) cut(a, radius_a, b, radius_b);
  if (b.z < near) cut(b, radius_b, a, radius_a);
  return true;
}

constexpr int band_rows = 64;          ///< rows of texels that one thread fills
constexpr size_t run_segments = 8192;  ///< segments that one thread sorts into bands

/// First texel whose centre is beyond `x`, which is >= -1.
int first_center(float x) {
  return static_cast<int>(x + 1.5f) - 1;
}

float clamp_texel(float x, int size) {
  return std::clamp(x, -1.0f, static_cast<float>(size) + 1.0f);
}

/// Corners so far off a view's axis are clipped, to a bit around what it sees.
constexpr float widest_tangent = 4;
constexpr float clip_tangent = 1.25f;

/// A triangle cut by up to five planes.
struct ClippedTriangle {
  vec3 corners[8];
  int count;
};

/// Cuts off what lies beyond a plane of a view's frustum: its four sides, then `near`
/// (Sutherland-Hodgman).
void clip_to_plane(float near, int plane, ClippedTriangle& triangle) {
  const auto inside = [&](vec3 p) {
    if (plane == 4) return p.z - near;
    return clip_tangent * p.z + (plane % 2 == 0 ? p[plane / 2] : -p[plane / 2]);
  };
  ClippedTriangle cut{{}, 0};
  for (int i = 0; i < triangle.count; ++i) {
    const vec3 p = triangle.corners[i];
    const vec3 q = triangle.corners[(i + 1) % triangle.count];
    const float from = inside(p);
    const float to = inside(q);
    if (from >= 0) cut.corners[cut.count++] = p;
    if ((from >= 0) == (to >= 0)) continue;
    vec3 at = p + (q - p) * (from / (from - to));
    at.z = std::max(at.z, near);
    cut.corners[cut.count++] = at;
  }
  triangle = cut;
}

}  // namespace

void DepthMap::reset(const LightPlane& view) {
  view_ = view;
  const size_t count = static_cast<size_t>(view.width) * view.height;
  texels_.resize(count);
  parallel_for(count, 1 << 16, [&](size_t begin, size_t end) {
    std::fill(texels_.begin() + static_cast<std::ptrdiff_t>(begin),
              texels_.begin() + static_cast<std::ptrdiff_t>(end), 0.0f);
  });
}

void DepthMap::raise(int x, int y, float nearness) {
  const std::atomic_ref<float> texel(texels_[static_cast<size_t>(y) * view_.width + x]);
  float seen = texel.load(std::memory_order_relaxed);
  while (nearness > seen &&
         !texel.compare_exchange_weak(seen, nearness, std::memory_order_relaxed)) {
  }
}

void DepthMap::draw_strands(const StrandSet& strands, std::span<const uint8_t> hidden) {
  projected_.resize(strands.points.size());
  parallel_for(strands.points.size(), 8192, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const vec4 point = strands.points[i];
      const vec3 p = view_.to_light(vec3(point));
      if (view_.perspective && p.z < view_.near) {
        projected_[i] = vec4(0, 0, 0, -1);
        continue;
      }
      const Projection at = view_.project(p);
      const float half = point.w * view_.scale * (view_.perspective ? at.nearness : 1.0f);
      projected_[i] = vec4(at.u, at.v, at.nearness, half);
    }
  });
  sort_segments(strands, hidden);
  const int bands = (view_.height + band_rows - 1) / band_rows;
  parallel_for(static_cast<size_t>(bands), 1, [&](size_t begin, size_t end) {
    for (size_t band = begin; band < end; ++band) draw_band(static_cast<int>(band));
  });
  parallel_for(runs_.size(), 1, [&](size_t begin, size_t end) {
    for (size_t run = begin; run < end; ++run) {
      for (const uint32_t segment : runs_[run].odd) {
        const vec4 a = strands.points[segment];
        const vec4 b = strands.points[segment + 1];
        draw_strand(view_.to_light(vec3(a)), view_.to_light(vec3(b)), a.w, b.w);
      }
    }
  });
}

void DepthMap::sort_segments(const StrandSet& strands, std::span<const uint8_t> hidden) {
  const size_t count = strands.segments.size();
  const int bands = (view_.height + band_rows - 1) / band_rows;
  runs_.resize((count + run_segments - 1) / run_segments);
  const auto width = static_cast<float>(view_.width);
  const auto height = static_cast<float>(view_.height);
  parallel_for(runs_.size(), 1, [&](size_t begin, size_t end) {
    for (size_t run = begin; run < end; ++run) {
      Bands& out = runs_[run];
      out.segments.resize(bands);
      for (auto& band : out.segments) band.clear();
      out.odd.clear();
      const size_t last = std::min(count, (run + 1) * run_segments);
      for (size_t i = run * run_segments; i < last; ++i) {
        const uint32_t segment = strands.segments[i];
        if (!hidden.empty() && hidden[segment] != 0 && hidden[segment + 1] != 0) continue;
        const vec4& a = projected_[segment];
        const vec4& b = projected_[segment + 1];
        const float half = std::max(a.w, b.w);
        if (std::min(a.w, b.w) < 0 || 2 * half > widest_line) {
          if (half >= 0) out.odd.push_back(segment);
          continue;
        }
        const float reach = widest_line;
        if (std::max(a.x, b.x) < -reach || std::min(a.x, b.x) > width + reach) continue;
        const float low = std::min(a.y, b.y) - reach;
        const float high = std::max(a.y, b.y) + reach;
        if (high < 0 || low > height) continue;
        const int first = static_cast<int>(std::max(low, 0.0f)) / band_rows;
        const int end_band =
            std::min(bands - 1, static_cast<int>(std::min(high, height)) / band_rows);
        for (int band = first; band <= end_band; ++band) out.segments[band].push_back(segment);
      }
    }
  });
}

template <bool steep>
void DepthMap::draw_line(const vec4& a, const vec4& b, int row0, int row1) {
  // `main` runs along the longer axis, `cross` along the other.
  constexpr int main = steep ? 1 : 0;
  constexpr int cross = 1 - main;
  const float main_d = b[main] - a[main];
  if (!(std::abs(main_d) > 0)) return;
  const float cross_d = b[cross] - a[cross];
  const int low_main = steep ? row0 : 0;
  const int high_main = steep ? row1 : view_.width;
  const int low_cross = steep ? 0 : row0;
  const int high_cross = steep ? view_.width : row1;
  const int first = std::max(low_main, first_center(std::max(-1.0f, std::min(a[main], b[main]))));
  const int last = std::min(high_main, first_center(std::max(-1.0f, std::max(a[main], b[main]))));
  const float slope = 1 / main_d;
  const float stretch = std::sqrt(1 + cross_d * cross_d * slope * slope);
  const float half_d = (b.w - a.w) * stretch;
  for (int i = first; i < last; ++i) {
    const float t = (static_cast<float>(i) + 0.5f - a[main]) * slope;
    const float center = a[cross] + t * cross_d;
    const float half = a.w * stretch + t * half_d;
    const int low = std::max(low_cross, first_center(std::max(-1.0f, center - half)));
    const int high = std::min(high_cross, first_center(std::max(-1.0f, center + half)));
    const float nearness = a.z + t * (b.z - a.z);
    for (int j = low; j < high; ++j) {
      const int x = steep ? j : i;
      const int y = steep ? i : j;
      float& texel = texels_[static_cast<size_t>(y) * view_.width + x];
      texel = std::max(texel, nearness);
    }
  }
}

void DepthMap::draw_band(int band) {
  const int row0 = band * band_rows;
  const int row1 = std::min(view_.height, row0 + band_rows);
  for (const Bands& run : runs_) {
    for (const uint32_t segment : run.segments[band]) {
      const vec4& a = projected_[segment];
      const vec4& b = projected_[segment + 1];
      if (std::abs(b.y - a.y) >= std::abs(b.x - a.x)) {
        draw_line<true>(a, b, row0, row1);
      } else {
        draw_line<false>(a, b, row0, row1);
      }
    }
  }
}

bool DepthMap::may_hold(const Bounds& box) const {
  // Corners in the light's frame: all beyond one side of the view means nothing of it is seen.
  int beyond[5] = {};
  for (int i = 0; i < 8; ++i) {
    const vec3 p = view_.to_light({(i & 1) != 0 ? box.high.x : box.low.x,
                                   (i & 2) != 0 ? box.high.y : box.low.y,
                                   (i & 4) != 0 ? box.high.z : box.low.z});
    const float depth = view_.perspective ? p.z : 1.0f;
    const float u = view_.scale * p.x + view_.offset_u * depth;
    const float v = view_.scale * p.y + view_.offset_v * depth;
    beyond[0] += u < 0;
    beyond[1] += u > static_cast<float>(view_.width) * depth;
    beyond[2] += v < 0;
    beyond[3] += v > static_cast<float>(view_.height) * depth;
    beyond[4] += depth <= 0;
  }
  return std::ranges::find(beyond, 8) == std::end(beyond);
}

void DepthMap::draw_triangles(const SceneStrips& strips) {
  constexpr size_t piece_grain = 2048;
  std::vector<std::pair<uint32_t, uint32_t>> parts;  // instance, first piece
  for (size_t i = 0; i < strips.instance_count(); ++i) {
    if (!strips.has_triangles(i) || !may_hold(strips.instance_bounds(i))) continue;
    for (uint32_t first = 0; first < strips.triangle_count(i); first += piece_grain) {
      parts.emplace_back(static_cast<uint32_t>(i), first);
    }
  }
  parallel_for(parts.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      strips.visit_triangles(parts[i].first, parts[i].second, parts[i].second + piece_grain,
                             [&](const Strip& piece) { draw(piece); });
    }
  });
}

uint64_t DepthMap::memory_bytes() const {
  uint64_t bytes = texels_.size() * sizeof(float) + projected_.size() * sizeof(vec4);
  for (const Bands& run : runs_) {
    for (const auto& band : run.segments) bytes += band.capacity() * sizeof(uint32_t);
  }
  return bytes;
}

void DepthMap::draw(const Strip& piece) {
  const vec3 a = view_.to_light(piece.p0);
  const vec3 b = view_.to_light(piece.p1);
  if (piece.is_strand()) {
    draw_strand(a, b, piece.r0, piece.r1);
  } else {
    draw_triangle(a, b, view_.to_light(piece.p2));
  }
}

void DepthMap::draw_strand(vec3 a, vec3 b, float radius_a, float radius_b) {
  if (view_.perspective && !clip_near(view_.near, a, b, radius_a, radius_b)) return;
  const Projection pa = view_.project(a);
  const Projection pb = view_.project(b);
  const float half_a = radius_a * view_.scale * (view_.perspective ? pa.nearness : 1);
  const float half_b = radius_b * view_.scale * (view_.perspective ? pb.nearness : 1);
  const float widest = std::max(half_a, half_b) + 1;
  if (std::max(pa.u, pb.u) < -widest ||
      std::min(pa.u, pb.u) > widest + static_cast<float>(view_.width) ||
      std::max(pa.v, pb.v) < -widest ||
      std::min(pa.v, pb.v) > widest + static_cast<float>(view_.height)) {
    return;
  }
  if (2 * std::max(half_a, half_b) <= widest_line) {
    draw_thin(pa, pb, half_a, half_b);
    return;
  }
  // The ribbon that faces the light.
  const vec3 towards = view_.perspective ? a + b : vec3(0, 0, 1);
  const vec3 side = normalize_or(glm::cross(b - a, towards), vec3(1, 0, 0));
  draw_triangle(a - radius_a * side, a + radius_a * side, b + radius_b * side);
  draw_triangle(a - radius_a * side, b + radius_b * side, b - radius_b * side);
}

void DepthMap::draw_thin(const Projection& a, const Projection& b, float half_a, float half_b) {
  const float du = b.u - a.u;
  const float dv = b.v - a.v;
  const bool steep = std::abs(dv) >= std::abs(du);
  // `main` runs along the longer axis, `cross` along the other.
  const float main_a = steep ? a.v : a.u;
  const float main_d = steep ? dv : du;
  const float cross_a = steep ? a.u : a.v;
  const float cross_d = steep ? du : dv;
  if (!(std::abs(main_d) > 0)) return;
  const int main_size = steep ? view_.height : view_.width;
  const int cross_size = steep ? view_.width : view_.height;
  const int first = first_center(clamp_texel(std::min(main_a, main_a + main_d), main_size));
  const int last = first_center(clamp_texel(std::max(main_a, main_a + main_d), main_size));
  const float slope = 1 / main_d;
  const float stretch = std::sqrt(1 + cross_d * cross_d * slope * slope);
  for (int i = std::max(0, first); i < std::min(last, main_size); ++i) {
    const float t = (static_cast<float>(i) + 0.5f - main_a) * slope;
    const float center = cross_a + t * cross_d;
    const float half = (half_a + t * (half_b - half_a)) * stretch;
    const int low = std::max(0, first_center(clamp_texel(center - half, cross_size)));
    const int high = std::min(cross_size, first_center(clamp_texel(center + half, cross_size)));
    const float nearness = a.nearness + t * (b.nearness - a.nearness);
    for (int j = low; j < high; ++j) raise(steep ? j : i, steep ? i : j, nearness);
  }
}

void DepthMap::draw_triangle(vec3 a, vec3 b, vec3 c) {
  const auto is_in_reach = [&](vec3 p) {
    return p.z >= view_.near && std::max(std::abs(p.x), std::abs(p.y)) <= widest_tangent * p.z;
  };
  if (!view_.perspective || (is_in_reach(a) && is_in_reach(b) && is_in_reach(c))) {
    const Projection pa = view_.project(a);
    const Projection pb = view_.project(b);
    const Projection pc = view_.project(c);
    fill_triangle(pa, pb, pc, make_slope(pa, pb, pc));
    return;
  }
  // Corners far off the axis lie where numbers are too coarse for slopes: these come from the
  // triangle in space.
  const vec3 normal = glm::cross(b - a, c - a);
  const float away = glm::dot(normal, a) * view_.scale;
  const NearnessSlope slope{normal.x / away, normal.y / away};
  ClippedTriangle clipped{{a, b, c}, 3};
  for (int plane = 0; plane < 5; ++plane) clip_to_plane(view_.near, plane, clipped);
  for (int i = 2; i < clipped.count; ++i) {
    fill_triangle(view_.project(clipped.corners[0]), view_.project(clipped.corners[i - 1]),
                  view_.project(clipped.corners[i]), slope);
  }
}

DepthMap::NearnessSlope DepthMap::make_slope(const Projection& a, const Projection& b,
                                             const Projection& c) {
  const float area = (b.u - a.u) * (c.v - a.v) - (c.u - a.u) * (b.v - a.v);
  if (!(std::abs(area) > 0)) return {};
  return {
      ((b.nearness - a.nearness) * (c.v - a.v) - (c.nearness - a.nearness) * (b.v - a.v)) / area,
      ((c.nearness - a.nearness) * (b.u - a.u) - (b.nearness - a.nearness) * (c.u - a.u)) / area};
}

void DepthMap::fill_triangle(const Projection& a, const Projection& b, const Projection& c,
                             const NearnessSlope& slope) {
  const int low_v = std::max(0, first_center(clamp_texel(std::min({a.v, b.v, c.v}), view_.height)));
  const int high_v =
      std::min(view_.height, first_center(clamp_texel(std::max({a.v, b.v, c.v}), view_.height)));
  if (low_v >= high_v) return;
  if (std::max({a.u, b.u, c.u}) < 0 || std::min({a.u, b.u, c.u}) > static_cast<float>(view_.width))
    return;
  const float most = std::max({a.nearness, b.nearness, c.nearness});
  const float least = std::min({a.nearness, b.nearness, c.nearness});
  const Projection* corners[3] = {&a, &b, &c};
  for (int y = low_v; y < high_v; ++y) {
    const float v = static_cast<float>(y) + 0.5f;
    float left = std::numeric_limits<float>::infinity();
    float right = -left;
    for (int e = 0; e < 3; ++e) {
      const Projection& p = *corners[e];
      const Projection& q = *corners[(e + 1) % 3];
      if ((p.v <= v) == (q.v <= v)) continue;
      const float u = p.u + (q.u - p.u) * ((v - p.v) / (q.v - p.v));
      left = std::min(left, u);
      right = std::max(right, u);
    }
    const int x0 = std::max(0, first_center(clamp_texel(left, view_.width)));
    const int x1 = std::min(view_.width, first_center(clamp_texel(right, view_.width)));
    const float start = a.nearness + (v - a.v) * slope.v - a.u * slope.u;
    for (int x = x0; x < x1; ++x) {
      raise(x, y, std::clamp(start + (static_cast<float>(x) + 0.5f) * slope.u, least, most));
    }
  }
}

}  // namespace relume
