#pragma once

#include <string>
#include <vector>

#include "core/base/progress.h"
#include "shadow/shadow.h"
#include "viewer/session/prepare.h"
#include "viewer/study/trial_log.h"

namespace relume {

/// One setting that a user can choose.
struct TradeoffTrial {
  ReductionMethod method = ReductionMethod::light_fit;
  int records = 8;  ///< k, at most; `all` has spp
  RecordBudget budget;
  CacheFormat format = CacheFormat::exact;
  ShadowMethod shadow = ShadowMethod::ray;
  PixelShare pixels = PixelShare::all;  ///< quarter: the others are filled in, see RelightParams
};

struct TradeoffParams {
  std::vector<TradeoffTrial> trials;  ///< those of the same records next to each other
  std::vector<int> traced_spp;        ///< pictures traced anew for every move, no records
  int spp = 25;                       ///< samples per pixel that records are made from
  int truth_spp = 256;  ///< of the truth, each with its ray; other samples than the records'
  int lights = 8;       ///< >= 2 random point lights that are moved to, one after the other
  int repeats = 3;      ///< rounds of all lights, each one's least time counts
  int width = 0;        ///< pixels; 0 = the scene's
  int height = 0;
  TrainingParams training;  ///< of the light metrics
  uint64_t seed = 0;
};

/// What a setting costs and how far its picture is from the truth.
struct TradeoffFigure {
  TradeoffTrial trial;
  int traced_spp = 0;         ///< > 0: traced anew, `trial` says nothing
  double error = 0;           ///< mean over lights of TR2007-600 eq. 7 over covered pixels
  double error_stddev = 0;    ///< over lights
  double error_half_95 = 0;   ///< half the 95 % confidence interval of the mean
  double reference_mean = 0;  ///< of the truth over covered pixels, lights and RGB
  double ms_light = 0;        ///< wall time of one light move, all threads, mean over lights
  double ms_prepare = 0;      ///< wall time from the scene to the records
  double cache_bytes = 0;
  double average_records = 0;  ///< per covered pixel
  bool is_pareto = false;      ///< no other figure has less error in less time
};

struct TradeoffStudy {
  int width = 0;  ///< pixels
  int height = 0;
  std::vector<TradeoffFigure> figures;
};

/// Measures every setting on the whole picture, and tracing with Embree beside them. Errors are
/// deterministic, times are not. Figures that `log` holds are taken from it, the others added. The
/// scene's materials emit nothing (see remove_emission).
TradeoffStudy study_tradeoff(const Scene& scene, const Tracer& tracer, const TradeoffParams& params,
                             TrialLog& log, const ProgressCallback& progress);

/// Marks the figures that no other one beats in both error and time.
void mark_pareto(std::vector<TradeoffFigure>& figures);

/// The figure of least error whose move takes `limit_ms` or less, the faster of equals; where none
/// does, the fastest. Figures traced anew do not count; null without others.
const TradeoffFigure* recommend(const std::vector<TradeoffFigure>& figures, double limit_ms);

}  // namespace relume
