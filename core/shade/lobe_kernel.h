#pragma once

#include "core/shade/kernel_light.h"
#include "core/simd/instruction_set.h"

namespace relume {

inline constexpr int max_lobes = 2;  ///< colours that a shader may have
inline constexpr int lobe_derivatives =
    3;  ///< along two tangents of the direction, and of ln(scalar)

/// Lights of one kind, one a lane, as arrays of floats; `count` is a multiple of 16.
struct KernelLightGroup {
  LightKernel kind;
  int count;
  const float* position[3];
  const float* to_light[3];
  const float* cos_outer;
  const float* inverse_cos_range;
  const float* inverse_range_squared;
};

/// One sample vector under one group of lights.
struct LobeQuery {
  int shader;           ///< index into the shader list
  const float* vector;  ///< one sample vector
  const float* eye;     ///< 3 floats, world
  float min_distance_squared;
  int direction;             ///< derivatives only: first float of the direction field
  int scalar;                ///< derivatives only: float of the scalar field, or -1
  const float* tangents[2];  ///< derivatives only: unit, orthogonal to the direction
  /// out[k * lobe_stride + light]: lobe k times irradiance. With derivatives, derivative d follows
  /// at out[k * lobe_stride + (1 + d) * derivative_stride + light].
  float* out;
  int lobe_stride;
  int derivative_stride;
};

struct LobeKernels {
  void (*lobes)(const LobeQuery&, const KernelLightGroup&);
  void (*lobes_and_derivatives)(const LobeQuery&, const KernelLightGroup&);
};

/// The kernels of `set` (already chosen, not automatic).
LobeKernels lobe_kernels(InstructionSet set);

namespace scalar {
LobeKernels make_lobe_kernels();
}
namespace sse42 {
LobeKernels make_lobe_kernels();
}
namespace avx2 {
LobeKernels make_lobe_kernels();
}
namespace avx512 {
LobeKernels make_lobe_kernels();
}

}  // namespace relume
