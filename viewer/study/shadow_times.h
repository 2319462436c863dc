#pragma once

#include "core/samples/relight_cache.h"
#include "core/trace/tracer.h"
#include "shadow/shadow_method.h"
#include "viewer/study/shadow_lights.h"

namespace relume {

/// Milliseconds of one light move: VisibilitySource::prepare and the visibility of every record of
/// the whole picture, all threads, without shading. 0 = not timed.
struct ShadowTimes {
  double ms_prepare = 0;
  double ms_move = 0;    ///< both
  double ms_coarse = 0;  ///< of a coarse frame's move: a quarter of the pixels (PixelShare)
  double coarse_ratio_to_ray = 0;  ///< ms_coarse to one traced ray a record of all pixels
  double ratio_to_ray = 0;         ///< to one traced ray a record, the same records
  double ratio_to_all = 0;         ///< to one traced ray a sample
  double records_per_s = 0;
};

/// The least of `repeats` moves along the light's path, on all records of `cache`; without ratios.
/// `shadow` is not `none`.
ShadowTimes time_moves(const Tracer& tracer, const RelightCache& cache, const StudyLight& light,
                       ShadowMethod shadow, int repeats);

}  // namespace relume
