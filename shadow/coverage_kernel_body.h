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
constexpr unsigned all_lanes = (1u << (native_width - 1) << 1) - 1u;

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

constexpr int gathered_values = 12;

struct Gathered {
  alignas(64) float value[gathered_values][lanes];  // as CoverageReceiver begins
};

/// Lanes from `count` on repeat the first.
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

/// (u, v, 1 / k) is the way to the light: its length, times k.
inline F length_along(F u, F v, float k) {
  return sqrt(fma(u * F(k), u * F(k), fma(v * F(k), v * F(k), F(1))));
}

/// What bounds a block, lane by lane.
struct Extents {
  float u_low[lanes], u_high[lanes], v_low[lanes], v_high[lanes];
  float far[lanes];   ///< the farthest depth that an occluder in front may have
  float size[lanes];  ///< root of three times the covariance's trace, over w
};

/// One native vector of lanes, from lane `lane` on.
inline void project_lanes(const Gathered& in, const CoverageView& view, int lane, float* block,
                          Extents& extents) {
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
  const F bias = load(9) * inverse2 / length_along(u, v, view.k);  // towards the light
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
  store(array_softness, reciprocal(F(2) * spread));
  store(array_l0, F(root_three) * l0);
  store(array_l1, F(root_three) * l1);
  store(array_l2, F(root_three) * l2);
  store(array_piece, load(11));
  const F reach_u = F(root_three) * l0;
  const F reach_v = F(root_three) * (absolute(l1) + l2);
  (u - reach_u).store(&extents.u_low[lane]);
  (u + reach_u).store(&extents.u_high[lane]);
  (v - reach_v).store(&extents.v_low[lane]);
  (v + reach_v).store(&extents.v_high[lane]);
  (z + fma(absolute(zu), reach_u, fma(absolute(zv), reach_v, spread))).store(&extents.far[lane]);
  (F(root_three) * sqrt(covariance[0] + covariance[3] + covariance[5]) * inverse)
      .store(&extents.size[lane]);
}

inline float lowest(const float (&value)[lanes]) {
  float low = value[0];
  for (int lane = 1; lane < lanes; ++lane) low = least(low, value[lane]);
  return low;
}
inline float highest(const float (&value)[lanes]) {
  float high = value[0];
  for (int lane = 1; lane < lanes; ++lane) high = most(high, value[lane]);
  return high;
}

inline void project(const CoverageReceiver* receivers, const CoverageView& view,
                    const uint32_t* index, int count, float* block, const CoverageBounds& bounds) {
  Gathered gathered;
  gather(receivers, index, count, gathered);
  Extents extents;
  for (int lane = 0; lane < lanes; lane += native_width) {
    project_lanes(gathered, view, lane, block, extents);
  }
  for (int lane = 0; lane < lanes; ++lane) {
    block[array_visible * lanes + lane] = lane < count ? 1.0f : 0.0f;
  }
  *bounds.u_low = lowest(extents.u_low);
  *bounds.u_high = highest(extents.u_high);
  *bounds.v_low = lowest(extents.v_low);
  *bounds.v_high = highest(extents.v_high);
  *bounds.z_high = highest(extents.far);
  *bounds.size_low = lowest(extents.size);
}

// ---- which primitives may reach which blocks ----

/// Primitives that are looked at together.
constexpr int batch_size = 256;

/// A rectangle of the picture, and the farthest depth in it.
struct Area {
  float u, v;              // middle
  float reach_u, reach_v;  // half its sides
  float z_high;
};

inline Area make_area(float u_low, float u_high, float v_low, float v_high, float z_high) {
  return {0.5f * (u_low + u_high), 0.5f * (v_low + v_high), 0.5f * (u_high - u_low),
          0.5f * (v_high - v_low), z_high};
}

/// What tells whether primitives of a kind reach an area, in arrays.
template <class Primitive>
struct Sieve;

template <>
struct Sieve<CoverageSegment> {
  static constexpr int fields = 7;
  alignas(64) float value[fields][batch_size + native_width];

  void fill(int i, const CoverageSegment& s) {
    const float half_length = 0.5f * s.length;
    value[0][i] = s.u + half_length * s.du;
    value[1][i] = s.v + half_length * s.dv;
    value[2][i] = s.du;
    value[3][i] = s.dv;
    value[4][i] = half_length;
    value[5][i] = s.half_high;
    value[6][i] = s.z_low;
  }

  /// > 0: apart from the area, along the segment, across it or in depth.
  F apart(int first, const Area& area) const {
    const auto load = [&](int field) { return F::load(&value[field][first]); };
    const F u = F(area.u) - load(0);
    const F v = F(area.v) - load(1);
    const F du = load(2);
    const F dv = load(3);
    const F side_u = absolute(du);
    const F side_v = absolute(dv);
    const F reach_u(area.reach_u);
    const F reach_v(area.reach_v);
    const F across =
        absolute(v * du - u * dv) - fma(reach_u, side_v, fma(reach_v, side_u, load(5)));
    const F along =
        absolute(fma(u, du, v * dv)) - fma(reach_u, side_u, fma(reach_v, side_v, load(4)));
    return max(max(across, along), load(6) - F(area.z_high));
  }
};

template <>
struct Sieve<CoverageTriangle> {
  static constexpr int fields = 14;
  alignas(64) float value[fields][batch_size + native_width];

  void fill(int i, const CoverageTriangle& t) {
    const float u_low = least(t.u[0], least(t.u[1], t.u[2]));
    const float u_high = most(t.u[0], most(t.u[1], t.u[2]));
    const float v_low = least(t.v[0], least(t.v[1], t.v[2]));
    const float v_high = most(t.v[0], most(t.v[1], t.v[2]));
    value[0][i] = 0.5f * (u_low + u_high);
    value[1][i] = 0.5f * (v_low + v_high);
    value[2][i] = 0.5f * (u_high - u_low);
    value[3][i] = 0.5f * (v_high - v_low);
    value[4][i] = t.z_low;
    // Half planes a u + b v <= c that hold it.
    const float area =
        (t.u[1] - t.u[0]) * (t.v[2] - t.v[0]) - (t.u[2] - t.u[0]) * (t.v[1] - t.v[0]);
    const float turn = area > 0 ? 1.0f : -1.0f;
    for (int side = 0; side < 3; ++side) {
      const int next = side == 2 ? 0 : side + 1;
      const float a = turn * (t.v[next] - t.v[side]);
      const float b = -turn * (t.u[next] - t.u[side]);
      value[5 + 3 * side][i] = a;
      value[6 + 3 * side][i] = b;
      value[7 + 3 * side][i] = a * t.u[side] + b * t.v[side];
    }
  }

  F apart(int first, const Area& area) const {
    const auto load = [&](int field) { return F::load(&value[field][first]); };
    const F u(area.u);
    const F v(area.v);
    const F reach_u(area.reach_u);
    const F reach_v(area.reach_v);
    F apart =
        max(absolute(u - load(0)) - load(2) - reach_u, absolute(v - load(1)) - load(3) - reach_v);
    apart = max(apart, load(4) - F(area.z_high));
    for (int side = 5; side < fields; side += 3) {
      const F a = load(side);
      const F b = load(side + 1);
      const F inner = fma(absolute(a), reach_u, fma(absolute(b), reach_v, load(side + 2)));
      apart = max(apart, fma(a, u, b * v) - inner);
    }
    return apart;
  }

  /// Whether it reaches one of the footprints, by its bounds.
  template <class Receivers>
  bool reaches(int i, const Receivers& receivers) const {
    const F apart_u = absolute(receivers.u - F(value[0][i])) - receivers.l0 - F(value[2][i]);
    const F apart_v = absolute(receivers.v - F(value[1][i])) - receivers.reach_v - F(value[3][i]);
    const F apart = max(max(apart_u, apart_v), F(value[4][i]) - receivers.far);
    return bits_of(apart > F(0)) != all_lanes;
  }
};

/// Primitives of a leaf, as many as are looked at together.
template <class Primitive>
struct Batch {
  int count = 0;
  const Primitive* primitives[batch_size];
  Sieve<Primitive> sieve;

  void add(const Primitive& primitive) {
    primitives[count] = &primitive;
    sieve.fill(count++, primitive);
  }
};

/// Calls visit(i) for each i of the sieve's first `count` that may reach the area.
template <class Primitive, class Visit>
void visit_reached(const Sieve<Primitive>& sieve, int count, const Area& area, const Visit& visit) {
  for (int first = 0; first < count; first += native_width) {
    unsigned reached = ~bits_of(sieve.apart(first, area) > F(0)) & all_lanes;
    const int left = count - first;
    if (left < native_width) reached &= (1u << left) - 1u;
    for (; reached != 0; reached &= reached - 1) visit(first + __builtin_ctz(reached));
  }
}

/// Those of `from` that may reach the area.
template <class Primitive>
void select_reached(const Batch<Primitive>& from, const Area& area, Batch<Primitive>& to) {
  to.count = 0;
  visit_reached(from.sieve, from.count, area, [&](int i) {
    to.primitives[to.count] = from.primitives[i];
    for (int field = 0; field < Sieve<Primitive>::fields; ++field) {
      to.sieve.value[field][to.count] = from.sieve.value[field][i];
    }
    ++to.count;
  });
}

// ---- shading ----

/// Part of a block that primitives are drawn onto: native_width receivers.
struct Footprints {
  F u, v, z, zu, zv, softness, l0, l1, l2;

  Footprints(const float* block, int lane) {
    const auto load = [&](int array) { return F::load(block + array * lanes + lane); };
    u = load(array_u);
    v = load(array_v);
    z = load(array_z);
    zu = load(array_zu);
    zv = load(array_zv);
    softness = load(array_softness);
    l0 = load(array_l0);
    l1 = load(array_l1);
    l2 = load(array_l2);
  }

  /// How much of an occluder counts that lies at `occluder` where the receivers are at `receiver`.
  F in_front(F receiver, F occluder) const {
    return clamp_to(fma(receiver - occluder, softness, F(0.5f)), F(0), F(1));
  }
};

/// Overlap of the segment with each footprint's extent along and across it.
inline F covered_by(const Footprints& receivers, const CoverageSegment& s) {
  const F u = receivers.u - F(s.u);
  const F v = receivers.v - F(s.v);
  const F du(s.du);
  const F dv(s.dv);
  const F along = fma(u, du, v * dv);
  const F across = v * du - u * dv;
  const F length(s.length);
  const F nearest = clamp_to(along, F(0), length);
  const F half = fma(F(s.half_slope), nearest, F(s.half));
  const F offset = nearest - along;
  const F offset_u = fma(offset, du, across * dv);
  const F offset_v = fma(offset, dv, F(0) - across * du);
  const F depth = fma(receivers.zu, offset_u, fma(receivers.zv, offset_v, receivers.z));
  const F front = receivers.in_front(depth, fma(F(s.z_slope), nearest, F(s.z)));
  const F along0 = fma(du, receivers.l0, dv * receivers.l1);
  const F along1 = dv * receivers.l2;
  const F across0 = du * receivers.l1 - dv * receivers.l0;
  const F across1 = du * receivers.l2;
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
  return overlap_across * overlap_along * (along_inverse * across_inverse * F(0.25f)) * front;
}

/// What a piece's parts cover, apart by the way they wind.
struct PieceCover {
  F front{0};
  F back{0};
};

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

/// Footprints and what triangles need beside.
struct SurfaceFootprints : Footprints {
  F m0, m2;   // 1 / l0, 1 / l2
  F reach_v;  // half the footprint's extent in v; in u it is l0
  F spread;   // of depths, half
  F far;      // the farthest depth that an occluder in front may have
  F piece;    // tag of the piece that the receiver lies on, or -1

  SurfaceFootprints(const float* block, int lane) : Footprints(block, lane) {
    m0 = reciprocal(l0);
    m2 = reciprocal(l2);
    reach_v = absolute(l1) + l2;
    spread = reciprocal(softness) * F(0.5f);
    far = z + fma(absolute(zu), l0, fma(absolute(zv), reach_v, spread));
    piece = F::load(block + array_piece * lanes + lane);
  }
};

/// The part of each footprint that a triangle of the receiver's own piece covers: all or nothing,
/// by the footprint's middle. A footprint is flat and a piece is not, it would shade itself.
inline void cover_own(const SurfaceFootprints& receivers, const CoverageTriangle& t,
                      Mask<native_width> is_own, PieceCover& cover) {
  const F u = receivers.u;
  const F v = receivers.v;
  F least_turn(0);
  F most_turn(0);
  for (int i = 0; i < 3; ++i) {
    const int j = i == 2 ? 0 : i + 1;
    const F turn =
        (F(t.u[j]) - F(t.u[i])) * (v - F(t.v[i])) - (F(t.v[j]) - F(t.v[i])) * (u - F(t.u[i]));
    least_turn = i == 0 ? turn : min(least_turn, turn);
    most_turn = i == 0 ? turn : max(most_turn, turn);
  }
  const F plane = fma(F(t.zu), u - F(t.u[0]), fma(F(t.zv), v - F(t.v[0]), F(t.z)));
  const F weight = select(plane < receivers.z + receivers.spread - F(t.slack), F(t.opacity), F(0));
  const F covered = select(is_own, weight, F(0));
  cover.front = cover.front + select(least_turn > F(0), covered, F(0));
  cover.back = cover.back + select(most_turn < F(0), covered, F(0));
}

/// Exact overlap of the triangle with each footprint's parallelogram.
inline void cover(const SurfaceFootprints& receivers, const CoverageTriangle& t,
                  PieceCover& cover) {
  const auto is_own = absolute(receivers.piece - F(piece_tag(t.piece))) < F(0.5f);
  if (bits_of(is_own) != 0) cover_own(receivers, t, is_own, cover);
  const F part = select(is_own, F(0), F(0.25f * t.opacity));
  F x[3];
  F y[3];
  F cx[3];
  for (int i = 0; i < 3; ++i) {
    x[i] = (F(t.u[i]) - receivers.u) * receivers.m0;
    y[i] = (F(t.v[i]) - receivers.v - receivers.l1 * x[i]) * receivers.m2;
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
  const F offset_u = middle_x * receivers.l0;
  const F offset_v = fma(middle_x, receivers.l1, middle_y * receivers.l2);
  const F depth = fma(receivers.zu, offset_u, fma(receivers.zv, offset_v, receivers.z));
  const F plane = fma(F(t.zu), receivers.u + offset_u - F(t.u[0]),
                      fma(F(t.zv), receivers.v + offset_v - F(t.v[0]), F(t.z)));
  const F weight = receivers.in_front(depth, clamp_to(plane, F(t.z_low), F(t.z_high))) * part;
  cover.front = fma(max(area, F(0)), weight, cover.front);
  cover.back = fma(max(F(0) - area, F(0)), weight, cover.back);
}

/// The piece that a block is being drawn, between batches.
struct OpenPiece {
  uint32_t piece = 0;
  bool is_open = false;
  bool is_sheet = false;
  float front[lanes];
  float back[lanes];
};

/// Finishes a piece: what its parts leave. The walls of a tube are one behind the other.
inline F close_piece(F visible, const PieceCover& cover, bool is_sheet) {
  const F covered = is_sheet ? cover.front + cover.back : max(cover.front, cover.back);
  return visible - visible * min(covered, F(1));
}

inline F load_visible(const float* block, int lane) {
  return F::load(block + array_visible * lanes + lane);
}

inline void close(float* block, OpenPiece& open) {
  if (!open.is_open) return;
  for (int lane = 0; lane < lanes; lane += native_width) {
    const PieceCover cover{F::load(&open.front[lane]), F::load(&open.back[lane])};
    close_piece(load_visible(block, lane), cover, open.is_sheet)
        .store(block + array_visible * lanes + lane);
  }
  open.is_open = false;
}

inline bool is_dark(const float* block) {
  unsigned bits = 0;
  for (int lane = 0; lane < lanes; lane += native_width) {
    bits |= bits_of(load_visible(block, lane) > F(dark_visibility));
  }
  return bits == 0;
}

inline bool is_sheet_of(const CoverageSegment&) {
  return false;
}
inline bool is_sheet_of(const CoverageTriangle& t) {
  return t.is_sheet != 0;
}

/// A block's visibility and open piece, while primitives are drawn onto some of its lanes.
template <class Primitive>
class LaneDrawer {
 public:
  LaneDrawer(float* block, const OpenPiece& open, int lane)
      : block_(block), lane_(lane), piece_(open.piece), is_sheet_(open.is_sheet) {
    visible_ = load_visible(block, lane);
    if (!open.is_open) return;
    cover_ = {F::load(&open.front[lane]), F::load(&open.back[lane])};
  }

  /// The piece that is drawn to from now on.
  PieceCover& cover_of(const Primitive& primitive) {
    if (primitive.piece != piece_) {
      visible_ = close_piece(visible_, cover_, is_sheet_);
      cover_ = {};
      piece_ = primitive.piece;
      is_sheet_ = is_sheet_of(primitive);
    }
    return cover_;
  }

  void store(OpenPiece& open) const {
    visible_.store(block_ + array_visible * lanes + lane_);
    cover_.front.store(&open.front[lane_]);
    cover_.back.store(&open.back[lane_]);
  }

 private:
  float* block_;
  int lane_;
  uint32_t piece_;
  bool is_sheet_;
  F visible_;
  PieceCover cover_;
};

/// Primitives that reach a block, as places in a batch.
struct Hits {
  int count = 0;
  uint16_t index[batch_size];
};

inline void draw(const Batch<CoverageSegment>& batch, const Hits& hits, float* block,
                 OpenPiece& open) {
  for (int lane = 0; lane < lanes; lane += native_width) {
    const Footprints receivers(block, lane);
    LaneDrawer<CoverageSegment> drawer(block, open, lane);
    for (int i = 0; i < hits.count; ++i) {
      const CoverageSegment& segment = *batch.primitives[hits.index[i]];
      PieceCover& cover = drawer.cover_of(segment);
      cover.front = cover.front + covered_by(receivers, segment);
    }
    drawer.store(open);
  }
}

inline void draw(const Batch<CoverageTriangle>& batch, const Hits& hits, float* block,
                 OpenPiece& open) {
  for (int lane = 0; lane < lanes; lane += native_width) {
    const SurfaceFootprints receivers(block, lane);
    LaneDrawer<CoverageTriangle> drawer(block, open, lane);
    for (int i = 0; i < hits.count; ++i) {
      const int at = hits.index[i];
      const CoverageTriangle& triangle = *batch.primitives[at];
      PieceCover& piece = drawer.cover_of(triangle);
      if (batch.sieve.reaches(at, receivers)) cover(receivers, triangle, piece);
    }
    drawer.store(open);
  }
}

/// The blocks of a leaf, and what is open on each.
template <class Primitive>
class LeafDrawer {
 public:
  explicit LeafDrawer(CoverageTask& task) : task_(task) {}

  void draw_batch() {
    for (int first = 0; first < task_.block_count; first += coverage_group_blocks) {
      int end = first + coverage_group_blocks;
      if (end > task_.block_count) end = task_.block_count;
      draw_group(first, end);
    }
    batch_.count = 0;
  }

  void add(const Primitive& primitive) {
    batch_.add(primitive);
    if (batch_.count == batch_size) draw_batch();
  }

  void finish() {
    if (batch_.count > 0) draw_batch();
    for (int b = 0; b < task_.block_count; ++b) {
      close(block_at(b), open_[b]);
      if (is_dark(block_at(b))) task_.bounds.z_high[b] = dark_depth;
    }
  }

 private:
  float* block_at(int b) { return task_.blocks + static_cast<int64_t>(b) * coverage_block_floats; }
  void draw_group(int first, int end) {
    const CoverageBounds& bounds = task_.bounds;
    float u_low = 0;
    float u_high = 0;
    float v_low = 0;
    float v_high = 0;
    float z_high = dark_depth;
    for (int b = first; b < end; ++b) {
      if (bounds.z_high[b] <= dark_depth) continue;
      const bool is_first = z_high <= dark_depth;
      u_low = is_first ? bounds.u_low[b] : least(u_low, bounds.u_low[b]);
      u_high = is_first ? bounds.u_high[b] : most(u_high, bounds.u_high[b]);
      v_low = is_first ? bounds.v_low[b] : least(v_low, bounds.v_low[b]);
      v_high = is_first ? bounds.v_high[b] : most(v_high, bounds.v_high[b]);
      z_high = is_first ? bounds.z_high[b] : most(z_high, bounds.z_high[b]);
    }
    if (z_high <= dark_depth) return;
    select_reached(batch_, make_area(u_low, u_high, v_low, v_high, z_high), near_);
    if (near_.count == 0) return;
    for (int b = first; b < end; ++b) {
      if (bounds.z_high[b] > dark_depth) draw_block(b);
    }
  }

  void draw_block(int b) {
    const CoverageBounds& bounds = task_.bounds;
    const Area area = make_area(bounds.u_low[b], bounds.u_high[b], bounds.v_low[b],
                                bounds.v_high[b], bounds.z_high[b]);
    Hits hits;
    visit_reached(near_.sieve, near_.count, area,
                  [&](int i) { hits.index[hits.count++] = static_cast<uint16_t>(i); });
    if (hits.count == 0) return;
    task_.tests += static_cast<uint64_t>(hits.count) * lanes;
    draw(near_, hits, block_at(b), open_[b]);
    const Primitive& last = *near_.primitives[hits.index[hits.count - 1]];
    open_[b].is_open = true;
    open_[b].piece = last.piece;
    open_[b].is_sheet = is_sheet_of(last);
    if (is_dark(block_at(b))) bounds.z_high[b] = dark_depth;
  }

  CoverageTask& task_;
  OpenPiece open_[max_task_blocks];
  Batch<Primitive> batch_;
  Batch<Primitive> near_;  ///< those that reach a group of blocks
};

/// Primitives lie anywhere: they are asked for so many before their turn.
constexpr uint64_t fetch_ahead = 8;

template <class Primitive>
void shade(CoverageTask& task, const CoverageList<Primitive>* lists, int list_count) {
  LeafDrawer<Primitive> drawer(task);
  for (int l = 0; l < list_count; ++l) {
    const CoverageList<Primitive>& list = lists[l];
    for (uint64_t i = 0; i < list.count; ++i) {
      if (i + fetch_ahead < list.count) {
        const Primitive* next = &list.primitives[list.order[i + fetch_ahead]];
        __builtin_prefetch(next);
        __builtin_prefetch(reinterpret_cast<const char*>(next + 1) - 1);
      }
      drawer.add(list.primitives[list.order[i]]);
    }
  }
  drawer.finish();
}

CoverageKernels make_coverage_kernels() {
  return {project, shade<CoverageSegment>, shade<CoverageTriangle>};
}

}  // namespace relume::RELUME_ISA
