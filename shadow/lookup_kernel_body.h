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

/// How the nearness of a lane's tangent plane changes from texel to texel; 0 on strands.
struct PlaneSlope {
  P u;
  P v;
};

inline PlaneSlope plane_slope(const DepthLookup& map, const LookupReceivers& receivers, int lane) {
  if (receivers.normal[0] == nullptr) return {P(0.0f), P(0.0f)};
  const Vec3<P> n{P::load(receivers.normal[0] + lane), P::load(receivers.normal[1] + lane),
                  P::load(receivers.normal[2] + lane)};
  const auto along = [&](int axis) {
    return fma(n.x, P(map.axes[axis][0]),
               fma(n.y, P(map.axes[axis][1]), n.z * P(map.axes[axis][2])));
  };
  P down = along(2);
  if (map.perspective) {
    const Vec3<P> p = load_positions(receivers, lane);
    down = fma(n.x, p.x - P(map.origin[0]),
               fma(n.y, p.y - P(map.origin[1]), n.z * (p.z - P(map.origin[2]))));
  }
  const P scale = P(1.0f) / (down * P(map.scale));
  return {along(0) * scale, along(1) * scale};
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
    const PlaneSlope slope = plane_slope(map, receivers, lane);
    const P du = to_float<W>(x0) + P(0.5f) - at.u;
    const P dv = to_float<W>(y0) + P(0.5f) - at.v;
    P before(-__builtin_inff());
    P farthest(__builtin_inff());
    for (int j = 0; j < 3; ++j) {
      const Index row = (y0 + j) * map.width + x0;
      const P down = (dv + P(static_cast<float>(j))) * slope.v;
      for (int i = 0; i < 3; ++i) {
        const P seen = gather<W>(map.texels, row + i);
        const P plane = fma(du + P(static_cast<float>(i)), slope.u, down);
        // The texel's own nearness counts: of two ways to be behind, one is enough.
        before = max(before, min(seen - plane, seen));
        farthest = min(farthest, seen);
      }
    }
    const P margin = P(0.05f / map.scale) * (map.perspective ? at.nearness : P(1.0f));
    const auto nothing = before < at.nearness + (receivers.normal[0] != nullptr ? margin : P(0.0f));
    const P sorted = select(farthest > at.limit, P(1.0f), select(nothing, P(0.0f), P(2.0f)));
    select(at.inside, sorted, P::load(state + lane)).store(state + lane);
  }
}

// --- grids of light ---

inline P lane_numbers() {
  float numbers[W];
  for (int i = 0; i < W; ++i) numbers[i] = static_cast<float>(i);
  return P::load(numbers);
}

inline P mix(P a, P b, P part) {
  return fma(b - a, part, a);
}

inline void sweep_row(float* cells, const SweepRow& row) {
  const P low(static_cast<float>(row.low));
  const P high(static_cast<float>(row.high));
  const P last(static_cast<float>(row.end - 1));
  for (int j = row.begin; j < row.end; j += W) {
    const P at = min(lane_numbers() + P(static_cast<float>(j)), last);
    const P from = min(max(fma(at, P(row.slope), P(row.start)), low), high);
    const Index near = to_int(from);
    const P part = from - to_float<W>(near);
    const Index far = to_int(min(to_float<W>(near) + P(1.0f), high)) * row.step;
    const Index first = near * row.step;
    const P upper =
        mix(gather<W>(cells, first + row.before[0]), gather<W>(cells, far + row.before[0]), part);
    const P lower =
        mix(gather<W>(cells, first + row.before[1]), gather<W>(cells, far + row.before[1]), part);
    const Index own = to_int(at) * row.step + row.first;
    const P left = gather<W>(cells, own) * mix(upper, lower, P(row.part));
    if (row.step == 1 && j + W <= row.end) {
      left.store(cells + row.first + j);
      continue;
    }
    float values[W];
    left.store(values);
    for (int i = 0; i < W && j + i < row.end; ++i)
      cells[row.first + (j + i) * row.step] = values[i];
  }
}

/// Where a ray from `p`, in cells, along `d` first lies between the centres of a grid's outer
/// cells, in lengths of d; 2^30 where it does not within [first, last].
inline P enter_grid(const LightGridLookup& grid, Vec3<P> p, Vec3<P> d, P first, P last) {
  const auto cut = [&](P at, P way, int size) {
    const P tiny(1e-12f);
    const P safe = select(abs(way) > tiny, way, tiny);
    const P a = (P(0.5f) - at) / safe;
    const P b = (P(static_cast<float>(size) - 0.5f) - at) / safe;
    first = max(first, min(a, b));
    last = min(last, max(a, b));
  };
  cut(p.x, d.x, grid.size[0]);
  cut(p.y, d.y, grid.size[1]);
  cut(p.z, d.z, grid.size[2]);
  return select(first > last, P(0x1p30f), first);
}

inline void look_up_light(const LightGridLookup& grid, const LookupReceivers& receivers,
                          float* passed) {
  const P inverse(grid.inverse_cell);
  const Index row = Index{} + grid.size[0];
  const Index slab = row * grid.size[1];
  for (int lane = 0; lane < lookup_lanes; lane += W) {
    const Vec3<P> world = load_positions(receivers, lane);
    const auto in_cells = [&](P x, int axis) { return (x - P(grid.origin[axis])) * inverse; };
    const Vec3<P> p{in_cells(world.x, 0), in_cells(world.y, 1), in_cells(world.z, 2)};
    const auto towards = [&](P at, int axis) {
      return grid.parallel ? P(grid.light[axis]) : P(grid.light[axis]) - at;
    };
    const Vec3<P> d{towards(p.x, 0), towards(p.y, 1), towards(p.z, 2)};
    const P length = max(max(abs(d.x), max(abs(d.y), abs(d.z))), P(1e-20f));
    // What leaves a cell is known half a cell behind its centre.
    const P skip = P(grid.gap + 0.5f) / length;
    const P last(grid.parallel ? 0x1p29f : 1.0f);
    const P t = enter_grid(grid, p, d, min(skip, last), last);
    const auto seen = t < P(0x1p29f);
    const P way = select(seen, t, P(0.0f));
    const auto place = [&](P at, P step, int axis) {
      const P most(static_cast<float>(grid.size[axis] - 1) - 1e-3f);
      return min(max(fma(step, way, at) - P(0.5f), P(0.0f)), most);
    };
    const P x = place(p.x, d.x, 0);
    const P y = place(p.y, d.y, 1);
    const P z = place(p.z, d.z, 2);
    const Index ix = to_int(x);
    const Index iy = to_int(y);
    const Index iz = to_int(z);
    const P fx = x - to_float<W>(ix);
    const P fy = y - to_float<W>(iy);
    const P fz = z - to_float<W>(iz);
    const Index at = iz * slab + iy * row + ix;
    const auto along_x = [&](Index first) {
      return mix(gather<W>(grid.cells, first), gather<W>(grid.cells, first + 1), fx);
    };
    const P near = mix(along_x(at), along_x(at + row), fy);
    const P far = mix(along_x(at + slab), along_x(at + slab + row), fy);
    select(seen, mix(near, far, fz), P(1.0f)).store(passed + lane);
  }
}

LookupKernels make_lookup_kernels() {
  return {look_up_depth, sort_by_depth, sweep_row, look_up_light};
}

}  // namespace relume::RELUME_ISA
