#pragma once

#include <string>
#include <vector>

#include "core/base/progress.h"
#include "reduction/reduction.h"
#include "reduction/training.h"
#include "shadow/shadow.h"
#include "viewer/study/shadow_times.h"
#include "viewer/study/shadow_truth.h"
#include "viewer/study/trial_log.h"
#include "viewer/study/visibility_error.h"

namespace relume {

/// One way to shadow one kind of records, to be measured. ReductionMethod::all with
/// ShadowMethod::ray traces a ray from each sample.
struct ShadowTrial {
  ShadowMethod shadow = ShadowMethod::ray;
  ReductionMethod method = ReductionMethod::strong_kmeans;
  int records = 8;  ///< k, at most; `all` has spp
};

struct ShadowStudyParams {
  std::vector<ShadowTrial> trials;
  int spp = 25;         ///< samples per pixel that records are made from
  int truth_spp = 256;  ///< of the truth, each with its ray; other samples than the records'
  int width = 0;        ///< pixels of the picture; 0 = the scene's
  int height = 0;
  int window = 0;      ///< measure so many pixels a side around the middle; 0 = the whole picture
  int steps = 3;       ///< of each light's path, for flicker
  bool timed = false;  ///< time light moves, on all records of the whole picture
  int repeats = 3;     ///< of a timed move, the least counts
  bool keep_maps = false;   ///< keep each trial's visibility
  TrainingParams training;  ///< of the light metrics
  uint64_t seed = 0;
};

/// One trial under one light. Visibility is the mean over a pixel's records, unshaded, 0
/// for those that the light cannot light (LitVisibility); all over the covered pixels of the
/// window.
struct ShadowLightFigure {
  std::string light;
  double truth_visibility = 0;  ///< its mean
  VisibilityError visibility;   ///< at the light's first place
  double flicker = 0;           ///< mean |change - the truth's change| over the steps
  double truth_change = 0;      ///< mean |the truth's change|: the flicker of a frozen shadow
  double error = 0;             ///< TR2007-600 eq. 7 of the shadowed picture against the truth
  double error_of_all = 0;      ///< the same against all samples, each with its ray
  double reference_mean = 0;    ///< mean value of the truth's picture over RGB
  std::vector<float> map;       ///< visibility by pixel of the window, when kept
};

struct ShadowFigure {
  ShadowTrial trial;
  double average_records = 0;  ///< per covered pixel
  std::vector<ShadowLightFigure> lights;
  ShadowTimes times;
  uint64_t structure_bytes = 0;  ///< what the approximator keeps; rays: the ray tracer's
};

struct ShadowStudy {
  StudyWindow window;
  std::vector<StudyLight> lights;
  ShadowTruth truth;
  std::vector<ShadowFigure> figures;  ///< as the trials; the reference "all, ray" comes first
};

/// Mean over a figure's lights; without a map.
ShadowLightFigure mean_figure(const ShadowFigure& figure);

/// Measures every trial, with all samples traced as the first. Deterministic but for the times.
/// The scene's materials emit nothing (see remove_emission).
/// Parts that `log` holds are taken from it, the others are added to it.
ShadowStudy study_shadows(const Scene& scene, const Tracer& tracer, const ShadowStudyParams& params,
                          TrialLog& log, const ProgressCallback& progress);

}  // namespace relume
