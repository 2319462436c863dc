#pragma once

#include <vector>

#include "reduction/methods/kmedoids.h"
#include "reduction/pixel_responses.h"

namespace relume {

/// A sample among those of all types.
struct FitSample {
  int type = 0;
  const float* vector = nullptr;
  const float* v = nullptr;      ///< 3 x columns, scaled
  const float* lobes = nullptr;  ///< max_lobes x columns, scaled, zeros where the type has fewer
};

/// The samples of one pixel in one list, types mixed, and what they look like: scaled so that all
/// that is fitted to them is of order 1, whatever the scene's exposure and units.
class FitPixel {
 public:
  explicit FitPixel(const LobeEvaluator& lobes) : evaluator(lobes) {}

  /// Evaluates the samples of the types for which `is_fitted` holds; their values must stay where
  /// they are until the next load. False when there is nothing to fit: none, or responses that are
  /// all black or not finite.
  bool load(std::span<const SampleMatrix> matrices, float weight_per_sample,
            const std::vector<bool>& is_fitted);

  /// What sample i costs in a cluster whose record has the lobes of candidate m: the part of its
  /// response that those lobes cannot explain with any colours >= 0, squared over lights and RGB,
  /// plus `position_weight` of its squared response times its squared distance from m over the
  /// pixel's mean squared distance. So samples that differ in colour alone cost nothing: their
  /// colours add. At most `max_candidates` samples, evenly spread over the list, stand as
  /// candidates.
  MedoidCosts unexplained(float position_weight, int max_candidates) const;

  int n() const { return static_cast<int>(samples.size()); }
  size_t length() const { return size_t(3) * columns; }

  const LobeEvaluator& evaluator;
  int columns = 0;
  float weight = 0;          ///< of one sample
  std::vector<float> scale;  ///< per column
  std::vector<FitSample> samples;

 private:
  bool find_scale();
  void make_responses(std::span<const SampleMatrix> matrices, const std::vector<bool>& is_fitted);

  PixelResponses responses_;
  std::vector<SampleMatrix> fitted_;
  std::vector<float> lobes_;  ///< n x max_lobes x columns
  std::vector<float> v_;      ///< n x 3 x columns
};

}  // namespace relume
