#pragma once

#include <string>
#include <vector>

#include "core/base/progress.h"
#include "shadow/shadow.h"
#include "viewer/session/prepare.h"
#include "viewer/study/trial_log.h"

namespace relume {

/// One way to make records, to be measured.
struct MethodTrial {
  ReductionMethod method = ReductionMethod::kmeans;
  int spp = 25;     ///< samples per pixel in; `pure` takes `records` instead
  int records = 8;  ///< k, at most
  RecordBudget budget;
  int training_lights = 0;     ///< of light metrics; 0 = MethodStudyParams::training's
  bool train_shadows = false;  ///< as well as where MethodStudyParams::training says so
};

/// How reduction methods are compared on one scene, without images: each of the chosen tiles is
/// sampled, reduced by every trial and seen under the test lights.
struct MethodStudyParams {
  std::vector<MethodTrial> trials;
  /// `none`, `ray` or both: pictures without shadows, or with one ray a record (a sample in the
  /// reference), of the same records.
  std::vector<ShadowMethod> shadows{ShadowMethod::none};
  int lights = 50;  ///< random point lights that no method is trained on, TR2007-600 sec. 4.2
  int width = 0;    ///< pixels; 0 = the scene's
  int height = 0;
  /// Every n-th tile is measured, from a random start: 1 is the whole image.
  int tile_stride = 1;
  int reference_spp = 25;  ///< of the picture that all are compared with: all its samples
  /// True: the reference has samples of its own, so that with many it is the truth. False: the
  /// samples of trials of reference_spp, so that the error is the reduction's alone.
  bool is_independent = false;
  TrainingParams training;  ///< of the light metrics
  uint64_t seed = 0;
};

/// How far one trial's picture is from the reference, in scene-linear units.
struct MethodFigure {
  MethodTrial trial;
  ShadowMethod shadow = ShadowMethod::none;
  std::vector<double> errors;   ///< per test light: TR2007-600 eq. 7 over covered pixels
  double error = 0;             ///< their mean
  double error_stddev = 0;      ///< their standard deviation
  double error_half_95 = 0;     ///< half the 95 % confidence interval of the mean
  double error_image = 0;       ///< the mean of eq. 7 over all pixels
  double reference_mean = 0;    ///< mean value of covered pixels, lights and RGB
  double predicted_error = 0;   ///< mean over covered pixels; 0 for methods that predict none
  double average_records = 0;   ///< per covered pixel
  double thread_ms_reduce = 0;  ///< without shadow rays that an earlier trial has traced
  int64_t covered_pixels = 0;
};

/// Measures every trial under every kind of shadow; one figure each, trial by trial. Deterministic
/// but for the times. Parts that `log` holds are taken from it, the others are added to it; the
/// figures are the same either way.
std::vector<MethodFigure> study_methods(const Scene& scene, const Tracer& tracer,
                                        const MethodStudyParams& params, TrialLog& log,
                                        const ProgressCallback& progress);

}  // namespace relume
