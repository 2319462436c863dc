#pragma once

// The coverage kernels, compiled once for each instruction set: see core/simd/pack.h for what may
// be called here.

#include "core/simd/pack.h"
#include "shadow/coverage_kernel.h"

namespace relume::RELUME_ISA {

using F = Pack<native_width>;
constexpr int lanes = coverage_lanes;
constexpr float tiny = 1e-30f;
constexpr float root_three = 1.7320508f;  // half side of a square with unit variance

inline float least(float a, float b) {
  return a < b ? a : b;
}
inline float most(float a, float b) {
  return a > b ? a : b;
}
inline F clamp_to(F x, F low, F high) {
  return min(max(x, low), high);
}
inline F absolute(F x) {
  return max(x, F(0) - x);
}
/// 1 / x, by a vector division.
inline F reciprocal(F x) {
  return F(1) / x;
}

// ---- projection ----

constexpr int gathered_values = 16;

struct Gathered {
  alignas(64) float value[gathered_values][lanes];  // as CoverageReceiver begins
};

inline void gather(const CoverageReceiver* receivers, const uint32_t* index, int count,
                   Gathered& out) {
  for (int lane = 0; lane < lanes; ++lane) {
    const float* row = receivers[index[lane < count ? lane : 0]].position;
    for (int i = 0; i < gathered_values; ++i) out.value[i][lane] = row[i];
  }
}

struct Vec {
  F x, y, z;
};

/// a' C b for the symmetric C.
inline F product(const F* c, Vec a, Vec b) {
  const F x = fma(c[0], b.x, fma(c[1], b.y, c[2] * b.z));
  const F y = fma(c[1], b.x, fma(c[3], b.y, c[4] * b.z));
  const F z = fma(c[2], b.x, fma(c[4], b.y, c[5] * b.z));
  return fma(a.x, x, fma(a.y, y, a.z * z));
}

/// One native vector of lanes, from lane `lane` on.
inline void project_lanes(const Gathered& in, const CoverageView& view, int lane, float* block) {
  const auto load = [&](int i) { return F::load(&in.value[i][lane]); };
  const auto row = [&](int i, int first) {
    const float* r = view.row[i];
    return fma(F(r[0]), load(first),
               fma(F(r[1]), load(first + 1), fma(F(r[2]), load(first + 2), F(r[3]))));
  };
  F covariance[6];
  for (int i = 0; i < 6; ++i) covariance[i] = load(3 + i);
  const F x = row(0, 0);
  const F y = row(1, 0);
  const F depth = row(2, 0);
  const F w = max(fma(F(view.k), depth, F(1)), F(1e-9f));
  const F inverse = reciprocal(w);
  const F u = x * inverse;
  const F v = y * inverse;
  // Derivatives of u, v and z with respect to the position.
  const auto derivative = [&](const float* r, F value) {
    const F scaled = value * F(view.k);
    return Vec{(F(r[0]) - scaled * F(view.row[2][0])) * inverse,
               (F(r[1]) - scaled * F(view.row[2][1])) * inverse,
               (F(r[2]) - scaled * F(view.row[2][2])) * inverse};
  };
  const Vec du = derivative(view.row[0], u);
  const Vec dv = derivative(view.row[1], v);
  const F inverse2 = inverse * inverse;
  const Vec dz{F(view.row[2][0]) * inverse2, F(view.row[2][1]) * inverse2,
               F(view.row[2][2]) * inverse2};
  const F cuu = product(covariance, du, du) + F(tiny);
  const F cuv = product(covariance, du, dv);
  const F cvv = product(covariance, dv, dv) + F(tiny);
  const F cuz = product(covariance, du, dz);
  const F cvz = product(covariance, dv, dz);
  const F czz = product(covariance, dz, dz);
  // The depth that goes with a place in the footprint, and the spread that is left.
  const F floor = (cuu + cvv) * F(1e-4f);
  const F ruu = cuu + floor;
  const F rvv = cvv + floor;
  const F determinant = max(ruu * rvv - cuv * cuv, F(tiny));
  const F zu = (rvv * cuz - cuv * cvz) / determinant;
  const F zv = (ruu * cvz - cuv * cuz) / determinant;
  const F rest = max(czz - zu * cuz - zv * cvz, F(0));
  // Towards the light by the bias; (u, v, 1 / k) is the way to the light.
  const F along = sqrt(fma(u * F(view.k), u * F(view.k), fma(v * F(view.k), v * F(view.k), F(1))));
  const F bias = load(9) * inverse2 / along;
  const F spread = max(F(root_three) * sqrt(rest), F(0.25f) * bias + F(1e-12f));
  const F z = depth * inverse - bias - load(10) * spread;
  const F l0 = sqrt(ruu);
  const F l1 = cuv / l0;
  const F l2 = sqrt(max(rvv - l1 * l1, floor + F(tiny)));
  const auto store = [&](int array, F value) { value.store(block + array * lanes + lane); };
  store(array_u, u);
  store(array_v, v);
  store(array_z, z);
  store(array_zu, zu);
  store(array_zv, zv);
  const F reach_u = F(root_three) * l0;
  const F reach_v = F(root_three) * (absolute(l1) + l2);
  store(array_size, F(root_three) * sqrt(covariance[0] + covariance[3] + covariance[5]) * inverse);
  store(array_reach_u, reach_u);
  store(array_reach_v, reach_v);
  store(array_far, z + fma(absolute(zu), reach_u, fma(absolute(zv), reach_v, spread)));
  store(array_softness, reciprocal(F(2) * spread));
  store(array_l0, F(root_three) * l0);
  store(array_l1, F(root_three) * l1);
  store(array_l2, F(root_three) * l2);
  store(array_m0, reciprocal(F(root_three) * l0));
  store(array_m2, reciprocal(F(root_three) * l2));
  store(array_piece, load(11));
  const F own_depth = row(2, 12);
  const F own_inverse = reciprocal(max(fma(F(view.k), own_depth, F(1)), F(1e-9f)));
  store(array_own_u, row(0, 12) * own_inverse);
  store(array_own_v, row(1, 12) * own_inverse);
  store(array_own_z, fma(own_depth, own_inverse, F(0) - load(15) * inverse2 / along));
  store(array_front, F(0));
  store(array_back, F(0));
}

/// Bounds of a block's footprints.
inline void bound_block(const float* block, int count, const CoverageBounds& bounds) {
  const auto at = [&](int array, int lane) { return block[array * lanes + lane]; };
  for (int lane = 0; lane < count; ++lane) {
    const float u = at(array_u, lane);
    const float v = at(array_v, lane);
    const float reach_u = at(array_reach_u, lane);
    const float reach_v = at(array_reach_v, lane);
    const float z = at(array_far, lane);
    const bool first = lane == 0;
    *bounds.u_low = first ? u - reach_u : least(*bounds.u_low, u - reach_u);
    *bounds.u_high = first ? u + reach_u : most(*bounds.u_high, u + reach_u);
    *bounds.v_low = first ? v - reach_v : least(*bounds.v_low, v - reach_v);
    *bounds.v_high = first ? v + reach_v : most(*bounds.v_high, v + reach_v);
    *bounds.z_high = first ? z : most(*bounds.z_high, z);
    const float size = at(array_size, lane);
    *bounds.size_low = first ? size : least(*bounds.size_low, size);
  }
}

inline void project(const CoverageReceiver* receivers, const CoverageView& view,
                    const uint32_t* index, int count, float* block, const CoverageBounds& bounds) {
  Gathered gathered;
  gather(receivers, index, count, gathered);
  for (int lane = 0; lane < lanes; lane += native_width) project_lanes(gathered, view, lane, block);
  for (int lane = 0; lane < lanes; ++lane) {
    block[array_visible * lanes + lane] = lane < count ? 1.0f : 0.0f;
  }
  bound_block(block, count, bounds);
}

// ---- shading ----

/// One native vector of a block's lanes.
struct Footprints {
  float* block;
  int lane;

  F load(int array) const { return F::load(block + array * lanes + lane); }
  void store(int array, F value) const { value.store(block + array * lanes + lane); }
};

/// Finishes the piece: what its parts leave. The walls of a tube are one behind the other.
inline void flush(const Footprints& receivers, bool is_sheet) {
  const F front = receivers.load(array_front);
  const F back = receivers.load(array_back);
  const F covered = min(is_sheet ? front + back : max(front, back), F(1));
  const F visible = receivers.load(array_visible);
  receivers.store(array_visible, visible - visible * covered);
  receivers.store(array_front, F(0));
  receivers.store(array_back, F(0));
}

/// How much of an occluder at depth `occluder` counts for receivers at `receiver`.
inline F in_front(const Footprints& receivers, F receiver, F occluder) {
  return clamp_to(fma(receiver - occluder, receivers.load(array_softness), F(0.5f)), F(0), F(1));
}

struct Segment {
  float u0, v0, z0;
  float du, dv;  // unit
  float length;
  float half0, half_slope;
  float z_slope;
};

inline Segment make_segment(const CoveragePrimitive& p) {
  Segment s;
  const float u = p.u[1] - p.u[0];
  const float v = p.v[1] - p.v[0];
  const float squared = u * u + v * v;
  s.length = squared > tiny ? __builtin_sqrtf(squared) : 0;
  const float inverse = s.length > 0 ? 1 / s.length : 0;
  s.du = s.length > 0 ? u * inverse : 1;
  s.dv = v * inverse;
  s.u0 = p.u[0];
  s.v0 = p.v[0];
  s.z0 = p.z[0];
  s.half0 = p.u[2];
  s.half_slope = (p.v[2] - p.u[2]) * inverse;
  s.z_slope = (p.z[1] - p.z[0]) * inverse;
  return s;
}

/// Overlap of the segment with each footprint's extent along and across it.
inline void shade_segment(const Footprints& receivers, const Segment& s) {
  const F u = receivers.load(array_u) - F(s.u0);
  const F v = receivers.load(array_v) - F(s.v0);
  const F along = fma(u, F(s.du), v * F(s.dv));
  const F across = v * F(s.du) - u * F(s.dv);
  const F length(s.length);
  const F nearest = clamp_to(along, F(0), length);
  const F half = fma(F(s.half_slope), nearest, F(s.half0));
  const F offset = nearest - along;
  const F offset_u = fma(offset, F(s.du), across * F(s.dv));
  const F offset_v = fma(offset, F(s.dv), F(0) - across * F(s.du));
  const F depth = fma(receivers.load(array_zu), offset_u,
                      fma(receivers.load(array_zv), offset_v, receivers.load(array_z)));
  const F front = in_front(receivers, depth, fma(F(s.z_slope), nearest, F(s.z0)));
  const F l0 = receivers.load(array_l0);
  const F l1 = receivers.load(array_l1);
  const F l2 = receivers.load(array_l2);
  const F along0 = fma(F(s.du), l0, F(s.dv) * l1);
  const F along1 = F(s.dv) * l2;
  const F across0 = F(s.du) * l1 - F(s.dv) * l0;
  const F across1 = F(s.du) * l2;
  const F along_squared = fma(along0, along0, fma(along1, along1, F(tiny)));
  const F across_squared = fma(across0, across0, fma(across1, across1, F(tiny)));
  const F along_inverse = rsqrt(along_squared);
  const F across_inverse = rsqrt(across_squared);
  const F along_half = along_squared * along_inverse;
  const F across_half = across_squared * across_inverse;
  const F overlap_across =
      max(min(across + half, across_half) - max(across - half, F(0) - across_half), F(0));
  const F overlap_along =
      max(min(along + along_half, length) - max(along - along_half, F(0)), F(0));
  const F covered =
      overlap_across * overlap_along * (along_inverse * across_inverse * F(0.25f)) * front;
  receivers.store(array_front, receivers.load(array_front) + covered);
}

struct Triangle {
  float piece;
  float u[3], v[3];
  float z0, zu, zv;  // plane through the first corner
  float z_low, z_high;
  float slack;  ///< in depth
  float opacity;
};

/// False when the triangle has no area in the picture.
inline bool make_triangle(const CoveragePrimitive& p, Triangle& t) {
  const float u1 = p.u[1] - p.u[0];
  const float v1 = p.v[1] - p.v[0];
  const float u2 = p.u[2] - p.u[0];
  const float v2 = p.v[2] - p.v[0];
  const float area = u1 * v2 - u2 * v1;
  const float scale = u1 * u1 + v1 * v1 + u2 * u2 + v2 * v2;
  if (!((area < 0 ? -area : area) > 1e-7f * scale)) return false;
  const float z1 = p.z[1] - p.z[0];
  const float z2 = p.z[2] - p.z[0];
  if (p.has_plane) {
    t.zu = p.plane[0];
    t.zv = p.plane[1];
    t.z0 = p.plane[2] + t.zu * p.u[0] + t.zv * p.v[0];
  } else {
    t.z0 = p.z[0];
    t.zu = (z1 * v2 - z2 * v1) / area;
    t.zv = (z2 * u1 - z1 * u2) / area;
  }
  t.slack = p.slack * (1 + most(t.zu, -t.zu) + most(t.zv, -t.zv));
  t.z_low = least(p.z[0], least(p.z[1], p.z[2]));
  t.z_high = most(p.z[0], most(p.z[1], p.z[2]));
  t.opacity = p.opacity;
  t.piece = piece_tag(p.piece);
  for (int i = 0; i < 3; ++i) {
    t.u[i] = p.u[i];
    t.v[i] = p.v[i];
  }
  return true;
}

/// Integral over y' <= y of the part of [-1, 1] below y'.
inline F integral_below(F y, F clamped) {
  const F inside = clamped + F(1);
  return fma(F(0.5f) * inside, inside, F(2) * max(y - F(1), F(0)));
}

/// Signed area between an edge and the bottom of the square [-1, 1]^2.
inline F edge_area(F x0, F y0, F xa, F x1, F y1, F xb) {
  const F run = x1 - x0;
  const F safe = select(absolute(run) < F(1e-12f), F(1e-12f), run);
  const F slope = (y1 - y0) / safe;
  const F ya = fma(slope, xa - x0, y0);
  const F yb = fma(slope, xb - x0, y0);
  const F rise = yb - ya;
  const F ca = clamp_to(ya, F(-1), F(1));
  const F cb = clamp_to(yb, F(-1), F(1));
  const auto flat = absolute(rise) < F(1e-3f);
  const F sloped = (integral_below(yb, cb) - integral_below(ya, ca)) / select(flat, F(1), rise);
  const F level = fma(F(0.5f), ca + cb, F(1));
  return (xb - xa) * select(flat, level, sloped);
}

/// The part of each footprint that a triangle of the receiver's own piece covers: all or nothing,
/// by a point that lies on the piece. A footprint is flat and a piece is not, it would shade
/// itself.
inline void shade_own(const Footprints& receivers, const Triangle& t, Mask<native_width> is_own) {
  const F u = receivers.load(array_own_u);
  const F v = receivers.load(array_own_v);
  F least_turn(0);
  F most_turn(0);
  for (int i = 0; i < 3; ++i) {
    const int j = i == 2 ? 0 : i + 1;
    const F turn =
        (F(t.u[j]) - F(t.u[i])) * (v - F(t.v[i])) - (F(t.v[j]) - F(t.v[i])) * (u - F(t.u[i]));
    least_turn = i == 0 ? turn : min(least_turn, turn);
    most_turn = i == 0 ? turn : max(most_turn, turn);
  }
  const F plane = fma(F(t.zu), u - F(t.u[0]), fma(F(t.zv), v - F(t.v[0]), F(t.z0)));
  const F weight = select(plane < receivers.load(array_own_z) - F(t.slack), F(t.opacity), F(0));
  const F own = select(is_own, weight, F(0));
  receivers.store(array_front, receivers.load(array_front) + select(least_turn > F(0), own, F(0)));
  receivers.store(array_back, receivers.load(array_back) + select(most_turn < F(0), own, F(0)));
}

/// Exact overlap of the triangle with each footprint's parallelogram.
inline void shade_triangle(const Footprints& receivers, const Triangle& t) {
  const auto is_own = absolute(receivers.load(array_piece) - F(t.piece)) < F(0.5f);
  if (bits_of(is_own) != 0) shade_own(receivers, t, is_own);
  const F u0 = receivers.load(array_u);
  const F v0 = receivers.load(array_v);
  const F m0 = receivers.load(array_m0);
  const F m2 = receivers.load(array_m2);
  const F l1 = receivers.load(array_l1);
  F x[3];
  F y[3];
  F cx[3];
  for (int i = 0; i < 3; ++i) {
    x[i] = (F(t.u[i]) - u0) * m0;
    y[i] = (F(t.v[i]) - v0 - l1 * x[i]) * m2;
    cx[i] = clamp_to(x[i], F(-1), F(1));
  }
  const F area = edge_area(x[0], y[0], cx[0], x[1], y[1], cx[1]) +
                 edge_area(x[1], y[1], cx[1], x[2], y[2], cx[2]) +
                 edge_area(x[2], y[2], cx[2], x[0], y[0], cx[0]);
  // About the middle of the overlap.
  const F third(1.0f / 3);
  const F middle_x = (cx[0] + cx[1] + cx[2]) * third;
  const F middle_y =
      (clamp_to(y[0], F(-1), F(1)) + clamp_to(y[1], F(-1), F(1)) + clamp_to(y[2], F(-1), F(1))) *
      third;
  const F offset_u = middle_x * receivers.load(array_l0);
  const F offset_v = fma(middle_x, l1, middle_y * receivers.load(array_l2));
  const F depth = fma(receivers.load(array_zu), offset_u,
                      fma(receivers.load(array_zv), offset_v, receivers.load(array_z)));
  const F plane =
      fma(F(t.zu), u0 + offset_u - F(t.u[0]), fma(F(t.zv), v0 + offset_v - F(t.v[0]), F(t.z0)));
  const F front = in_front(receivers, depth, clamp_to(plane, F(t.z_low), F(t.z_high)));
  const F weight = select(is_own, F(0), front * F(0.25f * t.opacity));
  receivers.store(array_front, fma(max(area, F(0)), weight, receivers.load(array_front)));
  receivers.store(array_back, fma(max(F(0) - area, F(0)), weight, receivers.load(array_back)));
}

constexpr unsigned all_lanes = (1u << (native_width - 1) << 1) - 1u;

/// Bounds of a primitive, for the test against blocks.
struct Box {
  float u_low, u_high, v_low, v_high, z_low;
};

inline Box make_box(const CoveragePrimitive& p) {
  const int corners = p.opacity > 0 ? 3 : 2;
  Box box{p.u[0], p.u[0], p.v[0], p.v[0], p.z[0]};
  for (int i = 1; i < corners; ++i) {
    box.u_low = least(box.u_low, p.u[i]);
    box.u_high = most(box.u_high, p.u[i]);
    box.v_low = least(box.v_low, p.v[i]);
    box.v_high = most(box.v_high, p.v[i]);
    box.z_low = least(box.z_low, p.z[i]);
  }
  if (corners == 2) {
    const float half = most(p.u[2], p.v[2]);
    box.u_low -= half;
    box.u_high += half;
    box.v_low -= half;
    box.v_high += half;
  }
  return box;
}

/// Whether the box reaches one of the lanes' footprints.
inline bool reaches(const Footprints& receivers, const Box& box) {
  const F u = absolute(receivers.load(array_u) - F(0.5f * (box.u_low + box.u_high)));
  const F v = absolute(receivers.load(array_v) - F(0.5f * (box.v_low + box.v_high)));
  const F apart_u = u - receivers.load(array_reach_u) - F(0.5f * (box.u_high - box.u_low));
  const F apart_v = v - receivers.load(array_reach_v) - F(0.5f * (box.v_high - box.v_low));
  const F apart = max(max(apart_u, apart_v), F(box.z_low) - receivers.load(array_far));
  return bits_of(apart > F(0)) != all_lanes;
}

/// Whether the segment reaches one of the lanes' footprints, along, across and in depth.
inline bool reaches(const Footprints& receivers, const Segment& s, float half, float z_low) {
  const F u = receivers.load(array_u) - F(s.u0);
  const F v = receivers.load(array_v) - F(s.v0);
  const F reach_u = receivers.load(array_reach_u);
  const F reach_v = receivers.load(array_reach_v);
  const float du = most(s.du, -s.du);
  const float dv = most(s.dv, -s.dv);
  const F across = absolute(v * F(s.du) - u * F(s.dv));
  const F along = absolute(fma(u, F(s.du), fma(v, F(s.dv), F(-0.5f * s.length))));
  const F apart_across = across - fma(reach_u, F(dv), fma(reach_v, F(du), F(half)));
  const F apart_along = along - fma(reach_u, F(du), fma(reach_v, F(dv), F(0.5f * s.length)));
  const F apart = max(max(apart_across, apart_along), F(z_low) - receivers.load(array_far));
  return bits_of(apart > F(0)) != all_lanes;
}

/// Half planes a u + b v <= c that hold the primitive: two for a segment, three for a triangle.
struct Sides {
  int count = 0;
  float a[3], b[3], c[3];
};

inline Sides make_sides(const Segment& s, float half) {
  Sides sides;
  const float middle = s.u0 * -s.dv + s.v0 * s.du;
  sides.count = 2;
  sides.a[0] = -s.dv;
  sides.b[0] = s.du;
  sides.c[0] = middle + half;
  sides.a[1] = s.dv;
  sides.b[1] = -s.du;
  sides.c[1] = half - middle;
  return sides;
}

inline Sides make_sides(const Triangle& t) {
  Sides sides;
  sides.count = 3;
  const float area = (t.u[1] - t.u[0]) * (t.v[2] - t.v[0]) - (t.u[2] - t.u[0]) * (t.v[1] - t.v[0]);
  const float turn = area > 0 ? 1.0f : -1.0f;
  for (int i = 0; i < 3; ++i) {
    const int j = i == 2 ? 0 : i + 1;
    sides.a[i] = turn * (t.v[j] - t.v[i]);
    sides.b[i] = -turn * (t.u[j] - t.u[i]);
    sides.c[i] = sides.a[i] * t.u[i] + sides.b[i] * t.v[i];
  }
  return sides;
}

/// Bits of the blocks from `first` on, native_width of them, that the primitive may reach.
inline unsigned reached_blocks(const CoverageBounds& bounds, int first, const Box& box,
                               const Sides& sides) {
  const F u_low = F::load(bounds.u_low + first);
  const F u_high = F::load(bounds.u_high + first);
  const F v_low = F::load(bounds.v_low + first);
  const F v_high = F::load(bounds.v_high + first);
  // Positive: apart.
  F apart = max(max(u_low - F(box.u_high), F(box.u_low) - u_high),
                max(v_low - F(box.v_high), F(box.v_low) - v_high));
  apart = max(apart, F(box.z_low) - F::load(bounds.z_high + first));
  for (int i = 0; i < sides.count; ++i) {
    const F u = F(sides.a[i]) * (sides.a[i] > 0 ? u_low : u_high);
    const F v = F(sides.b[i]) * (sides.b[i] > 0 ? v_low : v_high);
    apart = max(apart, u + v - F(sides.c[i]));
  }
  return ~bits_of(apart > F(0)) & all_lanes;
}

inline void flush_block(float* block, bool is_sheet) {
  for (int lane = 0; lane < lanes; lane += native_width) flush({block, lane}, is_sheet);
}

inline bool is_dark(const float* block) {
  unsigned bits = 0;
  for (int lane = 0; lane < lanes; lane += native_width) {
    bits |= bits_of(F::load(block + array_visible * lanes + lane) > F(dark_visibility));
  }
  return bits == 0;
}

/// A block that nothing reaches any more.
inline void retire(const CoverageBounds& bounds, int block) {
  bounds.z_high[block] = dark_depth;
}

/// Whether `reaches` is true of a lane of the block.
template <class Reaches>
bool is_any_reached(float* block, const Reaches& reaches_lanes) {
  for (int lane = 0; lane < lanes; lane += native_width) {
    if (reaches_lanes(Footprints{block, lane})) return true;
  }
  return false;
}

inline constexpr int max_task_blocks = 64;
/// Primitives lie anywhere: they are asked for so many before their turn.
constexpr uint64_t fetch_ahead = 8;

inline void shade(CoverageTask& task) {
  uint32_t last_piece[max_task_blocks];
  bool last_is_sheet[max_task_blocks];
  for (int b = 0; b < task.block_count; ++b) {
    last_piece[b] = 0xffffffffu;
    last_is_sheet[b] = false;
  }
  for (uint64_t i = 0; i < task.count; ++i) {
    if (i + fetch_ahead < task.count) {
      const CoveragePrimitive* next = &task.primitives[task.order[i + fetch_ahead]];
      __builtin_prefetch(next);
      __builtin_prefetch(reinterpret_cast<const char*>(next + 1) - 1);
    }
    const CoveragePrimitive& primitive = task.primitives[task.order[i]];
    const bool is_triangle = primitive.opacity > 0;
    Segment segment{};
    Triangle triangle{};
    Sides sides;
    if (is_triangle) {
      if (!make_triangle(primitive, triangle)) continue;
      sides = make_sides(triangle);
    } else {
      segment = make_segment(primitive);
      sides = make_sides(segment, most(primitive.u[2], primitive.v[2]));
    }
    const Box box = make_box(primitive);
    for (int first = 0; first < task.block_count; first += native_width) {
      unsigned reached = reached_blocks(task.bounds, first, box, sides);
      const int left = task.block_count - first;
      if (left < native_width) reached &= (1u << left) - 1u;
      for (; reached != 0; reached &= reached - 1) {
        const int b = first + __builtin_ctz(reached);
        float* block = task.blocks + static_cast<int64_t>(b) * coverage_block_floats;
        task.tests += lanes;
        const bool is_reached = is_any_reached(block, [&](const Footprints& receivers) {
          return is_triangle
                     ? reaches(receivers, box)
                     : reaches(receivers, segment, most(primitive.u[2], primitive.v[2]), box.z_low);
        });
        if (is_reached) {
          if (last_piece[b] != primitive.piece) {
            flush_block(block, last_is_sheet[b]);
            last_piece[b] = primitive.piece;
            last_is_sheet[b] = primitive.is_sheet;
            if (is_dark(block)) {
              retire(task.bounds, b);
              continue;
            }
          }
          for (int lane = 0; lane < lanes; lane += native_width) {
            if (is_triangle) {
              shade_triangle({block, lane}, triangle);
            } else {
              shade_segment({block, lane}, segment);
            }
          }
        }
      }
    }
  }
  for (int b = 0; b < task.block_count; ++b) {
    float* block = task.blocks + static_cast<int64_t>(b) * coverage_block_floats;
    flush_block(block, last_is_sheet[b]);
    if (is_dark(block)) retire(task.bounds, b);
  }
}

CoverageKernels make_coverage_kernels() {
  return {project, shade};
}

}  // namespace relume::RELUME_ISA
