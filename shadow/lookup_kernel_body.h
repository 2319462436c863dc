#pragma once

// Included by one tiny source file per instruction set: see core/simd/pack.h.

#include "core/simd/gather.h"
#include "shadow/lookup_kernel.h"

namespace relume::RELUME_ISA {

inline constexpr int W = native_width;
using P = Pack<W>;
using Index = Lanes<int32_t, W>::type;

inline Vec3<P> load_positions(const LookupReceivers& receivers, int lane) {
  return {P::load(receivers.position[0] + lane), P::load(receivers.position[1] + lane),
          P::load(receivers.position[2] + lane)};
}

inline P abs(P x) {
  return max(x, P(0.0f) - x);
}

// --- depth maps ---

struct DepthPlace {
  P u;
  P v;
  P nearness;  ///< of the receiver
  P limit;     ///< nearness above which something stands before the receiver
  Mask<W> inside;
};

inline DepthPlace place_in_map(const DepthLookup& map, Vec3<P> p, P bias) {
  const P dx = p.x - P(map.origin[0]);
  const P dy = p.y - P(map.origin[1]);
  const P dz = p.z - P(map.origin[2]);
  const auto along = [&](int axis) {
    return fma(dx, P(map.axes[axis][0]), fma(dy, P(map.axes[axis][1]), dz * P(map.axes[axis][2])));
  };
  const P x = along(0);
  const P y = along(1);
  const P z = along(2);
  if (!map.perspective) {
    const P own_bias = bias + P(map.bias_texels / map.scale);
    return {fma(x, P(map.scale), P(map.offset_u)), fma(y, P(map.scale), P(map.offset_v)),
            P(map.far) - z, P(map.far) - z + own_bias, x < P(__builtin_inff())};
  }
  const auto inside = (P(map.near) < z) & (!(z < abs(x))) & (!(z < abs(y)));
  const P depth = select(inside, z, P(1.0f));
  const P nearness = P(1.0f) / depth;
  const P scale = P(map.scale) * nearness;
  const P left = depth - bias - P(map.bias_texels / map.scale) * depth;
  const P limit = select(left > P(0.0f), P(1.0f) / left, P(__builtin_inff()));
  return {fma(x, scale, P(map.offset_u)), fma(y, scale, P(map.offset_v)), nearness, limit, inside};
}

inline void look_up_depth(const DepthLookup& map, const LookupReceivers& receivers, float* passed) {
  const P most_u(static_cast<float>(map.width - 3));
  const P most_v(static_cast<float>(map.height - 3));
  for (int lane = 0; lane < lookup_lanes; lane += W) {
    const DepthPlace at =
        place_in_map(map, load_positions(receivers, lane), P::load(receivers.bias + lane));
    if (!any(at.inside)) continue;
    const P u = min(max(at.u - P(1.0f), P(0.0f)), most_u);
    const P v = min(max(at.v - P(1.0f), P(0.0f)), most_v);
    const Index x0 = to_int(u);
    const Index y0 = to_int(v);
    const P fu = u - to_float<W>(x0);
    const P fv = v - to_float<W>(y0);
    const P weights_u[3] = {P(1.0f) - fu, P(1.0f), fu};
    const P weights_v[3] = {P(1.0f) - fv, P(1.0f), fv};
    P sum(0.0f);
    for (int j = 0; j < 3; ++j) {
      const Index row = (y0 + j) * map.width + x0;
      P hidden(0.0f);
      for (int i = 0; i < 3; ++i) {
        const P seen = gather<W>(map.texels, row + i);
        hidden = hidden + select(seen > at.limit, weights_u[i], P(0.0f));
      }
      sum = fma(hidden, weights_v[j], sum);
    }
    const P open = max(fma(sum, P(-0.25f), P(1.0f)), P(0.0f));
    const P old = P::load(passed + lane);
    select(at.inside, old * open, old).store(passed + lane);
  }
}

inline void sort_by_depth(const DepthLookup& map, const LookupReceivers& receivers, float* state) {
  const P most_u(static_cast<float>(map.width - 3));
  const P most_v(static_cast<float>(map.height - 3));
  for (int lane = 0; lane < lookup_lanes; lane += W) {
    const DepthPlace at =
        place_in_map(map, load_positions(receivers, lane), P::load(receivers.bias + lane));
    if (!any(at.inside)) continue;
    // The texel that holds the place is the middle one.
    const Index x0 = to_int(min(max(at.u - P(1.0f), P(0.0f)), most_u));
    const Index y0 = to_int(min(max(at.v - P(1.0f), P(0.0f)), most_v));
    P nearest(0.0f);
    P farthest(__builtin_inff());
    for (int j = 0; j < 3; ++j) {
      const Index row = (y0 + j) * map.width + x0;
      for (int i = 0; i < 3; ++i) {
        const P seen = gather<W>(map.texels, row + i);
        nearest = max(nearest, seen);
        farthest = min(farthest, seen);
      }
    }
    const P sorted =
        select(farthest > at.limit, P(1.0f), select(nearest < at.nearness, P(0.0f), P(2.0f)));
    select(at.inside, sorted, P::load(state + lane)).store(state + lane);
  }
}

// --- volumes ---

/// A ray in cells, its longest axis first and counted upwards.
struct VolumeRay {
  P main;  ///< place along the longest axis, mirrored where the ray runs down it
  P u;
  P v;
  P slope_u;  ///< cells along u for each along the longest axis
  P slope_v;
  P left;  ///< cells along the longest axis to the light
  Mask<W> down;
  Index size_main;
  Index size_u;
  Index size_v;
  Mask<W> main_x;  ///< the longest axis is x
  Mask<W> main_y;
};

template <class T, class Select>
T by_axis(const VolumeRay& ray, T x, T y, T z, const Select& choose) {
  return choose(ray.main_x, x, choose(ray.main_y, y, z));
}

inline VolumeRay start_ray(const VolumeLookup& volume, Vec3<P> p) {
  const P inverse(volume.inverse_cell);
  const auto in_cells = [&](P x, int axis) { return (x - P(volume.origin[axis])) * inverse; };
  const Vec3<P> cell{in_cells(p.x, 0), in_cells(p.y, 1), in_cells(p.z, 2)};
  const P away = P(volume.parallel ? 1.0f : 0.0f);
  const auto towards = [&](P x, int axis) {
    return volume.parallel ? P(volume.light[axis]) : (P(volume.light[axis]) - x) * inverse;
  };
  const Vec3<P> d{towards(p.x, 0), towards(p.y, 1), towards(p.z, 2)};
  const P ax = abs(d.x);
  const P ay = abs(d.y);
  const P az = abs(d.z);
  VolumeRay ray;
  ray.main_x = (!(ax < ay)) & (!(ax < az));
  ray.main_y = !(ay < az);
  const auto pick = [](Mask<W> m, P a, P b) { return select(m, a, b); };
  const auto pick_int = [](Mask<W> m, Index a, Index b) { return select_int<W>(m, a, b); };
  const Index zero{};
  const Index sx = zero + volume.size[0];
  const Index sy = zero + volume.size[1];
  const Index sz = zero + volume.size[2];
  ray.size_main = by_axis(ray, sx, sy, sz, pick_int);
  ray.size_u = by_axis(ray, sy, sz, sx, pick_int);
  ray.size_v = by_axis(ray, sz, sx, sy, pick_int);
  const P main_d = by_axis(ray, d.x, d.y, d.z, pick);
  const P length = max(by_axis(ray, ax, ay, az, pick), P(1e-30f));
  ray.slope_u = by_axis(ray, d.y, d.z, d.x, pick) / length;
  ray.slope_v = by_axis(ray, d.z, d.x, d.y, pick) / length;
  const P main = by_axis(ray, cell.x, cell.y, cell.z, pick);
  ray.down = main_d < P(0.0f);
  ray.main = select(ray.down, to_float<W>(ray.size_main) - main, main);
  // Skips the gap, then what lies before the grid.
  const P stretch = sqrt(fma(ray.slope_u, ray.slope_u, fma(ray.slope_v, ray.slope_v, P(1.0f))));
  P skip = P(volume.gap) / stretch;
  skip = max(skip, P(0.0f) - ray.main);
  ray.main = max(ray.main + skip, P(0.0f));
  ray.u = fma(ray.slope_u, skip, by_axis(ray, cell.y, cell.z, cell.x, pick));
  ray.v = fma(ray.slope_v, skip, by_axis(ray, cell.z, cell.x, cell.y, pick));
  ray.left = select(away > P(0.5f), P(1e30f), length) - skip;
  return ray;
}

/// Coverage at (u, v) of a slab of a level, interpolated; 0 beside the grid.
struct LevelPlace {
  const uint16_t* coverage;
  Index stride_main;
  Index stride_u;
  Index stride_v;
  Index size_main;
  P most_u;  ///< last place that has a neighbour
  P most_v;
};

inline P slab_coverage(const LevelPlace& level, Index slab, P u, P v, Mask<W> alive) {
  const auto inside =
      alive & (!(u < P(0.0f))) & (!(v < P(0.0f))) & (u < level.most_u) & (v < level.most_v);
  if (!any(inside)) return P(0.0f);
  const P safe_u = select(inside, u, P(0.0f));
  const P safe_v = select(inside, v, P(0.0f));
  const Index iu = to_int(safe_u);
  const Index iv = to_int(safe_v);
  const P fu = safe_u - to_float<W>(iu);
  const P fv = safe_v - to_float<W>(iv);
  const Index safe_slab = select_int<W>(inside, slab, Index{});
  const Index at = safe_slab * level.stride_main + iu * level.stride_u + iv * level.stride_v;
  const P c00 = gather_short<W>(level.coverage, at);
  const P c10 = gather_short<W>(level.coverage, at + level.stride_u);
  const P c01 = gather_short<W>(level.coverage, at + level.stride_v);
  const P c11 = gather_short<W>(level.coverage, at + level.stride_u + level.stride_v);
  const P low = fma(c10 - c00, fu, c00);
  const P high = fma(c11 - c01, fu, c01);
  return select(inside, fma(high - low, fv, low) * P(1.0f / 65535.0f), P(0.0f));
}

/// Crosses at most `steps` slabs of level l, lanes whose light is farther than `reach` cells.
inline void cross_level(const VolumeLookup& volume, int l, int steps, float reach, VolumeRay& ray,
                        P& pass) {
  const auto pick_int = [](Mask<W> m, Index a, Index b) { return select_int<W>(m, a, b); };
  const float scale = static_cast<float>(1 << l);
  const P inverse(1.0f / scale);
  const Index zero{};
  const Index sx = zero + 1;
  const Index sy = zero + (volume.size[0] >> l);
  const Index sz = sy * (volume.size[1] >> l);
  LevelPlace level;
  level.coverage = volume.coverage[l];
  level.stride_main = by_axis(ray, sx, sy, sz, pick_int);
  level.stride_u = by_axis(ray, sy, sz, sx, pick_int);
  level.stride_v = by_axis(ray, sz, sx, sy, pick_int);
  level.size_main = ray.size_main >> l;
  level.most_u = to_float<W>((ray.size_u >> l) - 1);
  level.most_v = to_float<W>((ray.size_v >> l) - 1);
  const P end = to_float<W>(level.size_main);
  for (int s = 0; s < steps; ++s) {
    const P at = ray.main * inverse;
    const auto alive = (at < end) & (ray.left > P(reach)) & (pass > P(1e-3f));
    if (!any(alive)) return;
    const Index slab = to_int(min(at, end));
    const P edge = to_float<W>(slab + 1);
    const P ahead = edge - at;
    const P part = select(alive, max(min(ahead, ray.left * inverse), P(0.0f)), P(0.0f));
    const P half = part * P(0.5f * scale);
    const P u = fma(fma(ray.slope_u, half, ray.u), inverse, P(-0.5f));
    const P v = fma(fma(ray.slope_v, half, ray.v), inverse, P(-0.5f));
    const Index own = select_int<W>(ray.down, level.size_main - 1 - slab, slab);
    const P covered = slab_coverage(level, own, u, v, alive);
    pass = pass * (P(1.0f) - part * covered);
    const P moved = part * P(scale);
    ray.main = select(part < ahead, ray.main + moved, edge * P(scale));
    ray.u = fma(ray.slope_u, moved, ray.u);
    ray.v = fma(ray.slope_v, moved, ray.v);
    ray.left = ray.left - moved;
  }
}

/// Fine slabs at the receiver, then coarser ones, and finer ones again where the light is near.
inline void march_lanes(const VolumeLookup& volume, VolumeRay ray, float* passed) {
  constexpr int coarsest = VolumeLookup::max_levels - 1;
  constexpr int no_limit = 1 << 20;
  P pass(1.0f);
  const auto reach = [&volume](int l) {
    return l < 0 ? 0.0f : static_cast<float>(volume.steps << l);
  };
  for (int l = 0; l < coarsest; ++l) cross_level(volume, l, volume.steps, reach(l), ray, pass);
  for (int l = coarsest; l >= 0; --l) cross_level(volume, l, no_limit, reach(l - 1), ray, pass);
  pass.store(passed);
}

inline void march_volume(const VolumeLookup& volume, const LookupReceivers& receivers,
                         float* passed) {
  for (int lane = 0; lane < lookup_lanes; lane += W) {
    march_lanes(volume, start_ray(volume, load_positions(receivers, lane)), passed + lane);
  }
}

LookupKernels make_lookup_kernels() {
  return {look_up_depth, sort_by_depth, march_volume};
}

}  // namespace relume::RELUME_ISA
