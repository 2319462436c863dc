#pragma once

#include "core/math/vec.h"
#include "core/samples/sample_type.h"

namespace relume::test {

/// What float arithmetic may make of one record's response to one light.
struct ResponseBound {
  dvec3 exact;      ///< reference_response
  dvec3 tolerance;  ///< how far from it a float kernel may be
};

/// The tolerance is a relative rounding bound of 1e-5 (1e-5 + 3e-7 e under a power of e), and four
/// times what the reference itself moves when its directions are off by 4e-7 and its position by
/// `position_error` (world units; of packed formats, which instruction sets decode with different
/// last bits), as the largest of `jitters` random tries shows it. Near an exponent of 1e5, a
/// grazing angle or the light itself the problem is ill-conditioned, whoever computes it.
ResponseBound bound_response(const SampleType& type, const float* vector, const Light& light,
                             dvec3 eye, double scene_radius, double position_error = 0,
                             int jitters = 24);

}  // namespace relume::test
