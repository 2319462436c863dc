#pragma once

#include "core/simd/instruction_set.h"

namespace relume {

inline constexpr int row_lanes = 16;

/// Loops over the rows of small matrices, one row a lane, for clustering. `stride` counts the
/// lanes: rows, padded to a multiple of row_lanes; what padding holds reaches no other lane. Every
/// lane sums in a fixed order and without fused multiply-add: results are bit-equal on all
/// instruction sets. Thread-safe, no allocation.
struct RowKernels {
  /// Squared distances of all rows from each of `count` points of `dimensions` floats, one after
  /// the other: out[point * stride + row]. `columns` holds coordinate i of the rows at
  /// columns[i * stride + row].
  void (*distances)(const float* columns, int dimensions, int stride, const float* points,
                    int count, float* out);
  /// nearest[row] = the point of least distance, of `count` whose distances stand as above; ties
  /// and NaN go to the lower point. `nearest` holds `stride` ints.
  void (*nearest)(const float* distances, int count, int stride, int* nearest);
  /// Squared distances out[row] of all rows from the centroid of `count` > 0 `members`, from the
  /// squared distances pairs[row * stride + row'] alone, whatever the number of dimensions:
  ///   |x - centroid|^2 = 1/m sum_y |x - y|^2 - variance,
  ///   variance = 1/(2 m^2) sum_y sum_z |y - z|^2,
  /// y and z over the m members. Returns the variance: exactly 0 where all members coincide.
  float (*centroid_distances)(const float* pairs, int stride, const int* members, int count,
                              float* out);
  /// least[row] = the lesser of itself and distances[row], unless that is NaN; then sums[lane], of
  /// row_lanes, = the sum of least over every row_lanes-th row from `lane` on.
  void (*lower)(const float* distances, int stride, float* least, float* sums);
};

/// The kernels of `set` (already chosen, not automatic).
RowKernels row_kernels(InstructionSet set);

/// Those of the best instruction set of this machine.
const RowKernels& best_row_kernels();

namespace scalar {
RowKernels make_row_kernels();
}
namespace sse42 {
RowKernels make_row_kernels();
}
namespace avx2 {
RowKernels make_row_kernels();
}
namespace avx512 {
RowKernels make_row_kernels();
}

}  // namespace relume
