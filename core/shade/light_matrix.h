#pragma once

#include <vector>

#include "core/samples/sample_type.h"
#include "core/shade/lobe_kernel.h"

namespace relume {

/// A set of lights to evaluate samples under, for instance the training lights of TR2007-600
/// sec. 3.2. Column j of every matrix below belongs to one light; columns are grouped by the
/// lights' kinds and each group is padded to a multiple of 16 with copies whose weight is 0.
struct LightSet {
  std::vector<Light> lights;      ///< per column; padding repeats a light of the group
  std::vector<float> weights[3];  ///< per column and channel: color * gain, 0 for padding
  /// Per column: position, to_light, cos_outer, inverse_cos_range, inverse_range_squared.
  std::vector<float> arrays[9];
  std::vector<LightKernel> kinds;  ///< per group of 16 columns
  float min_distance_squared = 0;
  int light_count = 0;  ///< l, without padding

  std::vector<bool> padding;  ///< per column

  int columns() const { return static_cast<int>(lights.size()); }
};

/// `scene_radius` in world units.
LightSet make_light_set(std::span<const Light> lights, float scene_radius);

/// Evaluates the lobes of sample vectors under a light set: what a response is made of before its
/// colours. Vectorised over lights on the best instruction set. Thread-safe; no allocation.
class LobeEvaluator {
 public:
  /// `types` and `lights` must outlive the evaluator. `eye` in world space.
  LobeEvaluator(std::span<const SampleType> types, const LightSet& lights, vec3 eye,
                InstructionSet set = InstructionSet::automatic);

  const LightSet& lights() const { return *lights_; }
  int type_count() const { return static_cast<int>(shapes_.size()); }
  /// Floats per sample vector of a type.
  int vector_width(int type) const { return shapes_[type].width; }
  /// Number of lobes (colours) of a type, and the first float of lobe k's colour.
  int lobe_count(int type) const { return shapes_[type].lobe_count; }
  int color_offset(int type, int lobe) const { return shapes_[type].colors[lobe]; }
  /// First float of the type's direction, and of its last scalar, which is the width of its
  /// highlight; -1 where it has none. The largest value of that scalar.
  int direction_offset(int type) const { return shapes_[type].direction; }
  int scalar_offset(int type) const { return shapes_[type].scalar; }
  float largest_scalar(int type) const { return shapes_[type].largest_scalar; }
  /// True when the sign of the type's direction means nothing (a strand's tangent).
  bool is_axis(int type) const { return shapes_[type].is_axis; }

  /// out[k * columns + j] = lobe k of the sample vector times the irradiance of light j at
  /// weight 1.
  void lobes(int type, const float* vector, float* out) const;

  /// out[(k * 4 + d) * columns + j]: d = 0 the lobe, 1 and 2 its derivatives when the direction
  /// turns towards the two unit tangents, 3 its derivative with respect to the logarithm of the
  /// scalar.
  void lobes_and_derivatives(int type, const float* vector, vec3 tangent0, vec3 tangent1,
                             float* out) const;

 private:
  struct Shape {
    int shader = 0;
    int width = 0;
    int lobe_count = 0;
    int colors[max_lobes] = {};
    int direction = -1;
    int scalar = -1;
    float largest_scalar = 0;
    bool is_axis = false;
  };

  std::vector<Shape> shapes_;
  const LightSet* lights_;
  float eye_[3];
  LobeKernels kernels_;
};

/// V, the n x l matrix of rendered values of TR2007-600 sec. 3.2: v[(row * 3 + c) * columns + j] is
/// channel c of sample `row` under light j alone, at the light's own weight, unshadowed. `lobes`
/// are those of the rows, max_lobes * columns floats each.
void shade_rows(const LobeEvaluator& evaluator, int type, const float* vectors, int rows,
                const float* lobes, float* v);

}  // namespace relume
