#pragma once

#include <memory>
#include <vector>

#include "shadow/light_plane.h"
#include "shadow/strips.h"

namespace relume {

/// What a light sees first, texel by texel: the nearness of the nearest piece that covers the
/// texel's centre, as a ray through it would find; 0 where there is none. Drawing takes the larger
/// nearness, so any order and any number of threads gives the same map.
class DepthMap {
 public:
  DepthMap() = default;
  explicit DepthMap(const LightPlane& view) { reset(view); }

  /// Empties the map and gives it a new view; keeps its memory.
  void reset(const LightPlane& view);

  const LightPlane& view() const { return view_; }
  /// Rows of view().width texels.
  const float* texels() const { return texels_.data(); }
  uint64_t memory_bytes() const;

  /// Draws a piece; thread-safe among themselves. Cut-outs are drawn whole.
  void draw(const Strip& piece);

  /// Draws the triangles of all instances with all threads; instances that the view does not hold
  /// cost nothing.
  void draw_triangles(const SceneStrips& strips);

  /// Draws all strands with all threads, each thread rows of its own. Segments both of whose points
  /// are 1 in `hidden`, by point or empty, are left out.
  void draw_strands(const StrandSet& strands, std::span<const uint8_t> hidden = {});

 private:
  void draw_strand(vec3 a, vec3 b, float radius_a, float radius_b);
  void draw_thin(const LightPlane::Projection& a, const LightPlane::Projection& b, float half_a,
                 float half_b);
  void draw_triangle(vec3 a, vec3 b, vec3 c);
  /// Of a triangle's nearness, a texel.
  struct NearnessSlope {
    float u = 0;
    float v = 0;
  };
  static NearnessSlope make_slope(const LightPlane::Projection& a, const LightPlane::Projection& b,
                                  const LightPlane::Projection& c);
  void fill_triangle(const LightPlane::Projection& a, const LightPlane::Projection& b,
                     const LightPlane::Projection& c, const NearnessSlope& slope);
  void raise(int x, int y, float nearness);
  void sort_segments(const StrandSet& strands, std::span<const uint8_t> hidden);
  void draw_band(int band);
  template <bool steep>
  void draw_line(const vec4& a, const vec4& b, int row0, int row1);
  bool may_hold(const Bounds& box) const;

  /// Segments that a run of them puts into each band of rows.
  struct Bands {
    std::vector<std::vector<uint32_t>> segments;
    std::vector<uint32_t> odd;  ///< those too wide or too near to be lines
  };

  LightPlane view_;
  std::vector<float> texels_;
  std::vector<vec4> projected_;  ///< of the strands' points: u, v, nearness, half width; texels
  std::vector<Bands> runs_;
};

}  // namespace relume
