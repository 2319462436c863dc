#pragma once

#include <memory>
#include <vector>

#include "shadow/light_view.h"
#include "shadow/strips.h"

namespace relume {

/// What a light sees first, texel by texel: the nearness of the nearest piece that covers the
/// texel's centre, as a ray through it would find; 0 where there is none. Drawing takes the larger
/// nearness, so any order and any number of threads gives the same map.
class DepthMap {
 public:
  DepthMap() = default;
  explicit DepthMap(const LightView& view) { reset(view); }

  /// Empties the map and gives it a new view; keeps its memory.
  void reset(const LightView& view);

  const LightView& view() const { return view_; }
  /// Rows of view().width texels.
  const float* texels() const { return texels_.data(); }
  size_t memory_bytes() const { return texels_.size() * sizeof(float); }

  /// Draws a piece; thread-safe among themselves. Cut-outs are drawn whole.
  void draw(const ThinPiece& piece);

  /// Draws all strands with all threads, each thread rows of its own.
  void draw_strands(const StrandSet& strands);

 private:
  void draw_strand(vec3 a, vec3 b, float radius_a, float radius_b);
  void draw_thin(const LightView::Projection& a, const LightView::Projection& b, float half_a,
                 float half_b);
  void draw_triangle(vec3 a, vec3 b, vec3 c);
  void fill_triangle(const LightView::Projection& a, const LightView::Projection& b,
                     const LightView::Projection& c);
  void raise(int x, int y, float nearness);
  void sort_segments(const StrandSet& strands);
  void draw_band(int band, const StrandSet& strands);

  /// Segments that a run of them puts into each band of rows.
  struct Bands {
    std::vector<std::vector<uint32_t>> segments;
    std::vector<uint32_t> odd;  ///< those too wide or too near to be lines
  };

  LightView view_;
  std::vector<float> texels_;
  std::vector<vec4> projected_;  ///< of the strands' points: u, v, nearness, half width; texels
  std::vector<Bands> runs_;
};

}  // namespace relume
