#pragma once

// Included by one tiny source file per instruction set: see core/simd/pack.h.

#include "core/simd/pack.h"
#include "core/simd/row_kernels.h"

namespace relume::RELUME_ISA {

using RowPack = Pack<native_width>;

/// Distances from `Points` points at once, which hides the latency of the sums.
template <int Points>
void eval_row_distances(const float* columns, int dimensions, int stride, const float* points,
                        float* out) {
  for (int first = 0; first < stride; first += native_width) {
    RowPack sums[Points];
    for (int j = 0; j < Points; ++j) sums[j] = RowPack(0.0f);
    for (int i = 0; i < dimensions; ++i) {
      const RowPack rows = RowPack::load(columns + i * stride + first);
      for (int j = 0; j < Points; ++j) {
        const RowPack d = rows - RowPack(points[j * dimensions + i]);
        sums[j] = sums[j] + d * d;
      }
    }
    for (int j = 0; j < Points; ++j) sums[j].store(out + j * stride + first);
  }
}

inline void row_distances(const float* columns, int dimensions, int stride, const float* points,
                          int count, float* out) {
  int j = 0;
  for (; j + 4 <= count; j += 4) {
    eval_row_distances<4>(columns, dimensions, stride, points + j * dimensions, out + j * stride);
  }
  for (; j < count; ++j) {
    eval_row_distances<1>(columns, dimensions, stride, points + j * dimensions, out + j * stride);
  }
}

inline void nearest_points(const float* distances, int count, int stride, int* nearest) {
  for (int first = 0; first < stride; first += native_width) {
    RowPack least(__builtin_inff());
    RowPack point(0.0f);
    for (int j = 0; j < count; ++j) {
      const RowPack d = RowPack::load(distances + j * stride + first);
      const auto closer = d < least;
      least = select(closer, d, least);
      point = select(closer, RowPack(static_cast<float>(j)), point);
    }
    const auto indices = to_int(point);
    __builtin_memcpy(nearest + first, &indices, sizeof(indices));
  }
}

inline float centroid_distances(const float* pairs, int stride, const int* members, int count,
                                float* out) {
  for (int first = 0; first < stride; first += native_width) {
    RowPack sum = RowPack::load(pairs + members[0] * stride + first);
    for (int m = 1; m < count; ++m) {
      sum = sum + RowPack::load(pairs + members[m] * stride + first);
    }
    sum.store(out + first);
  }
  if (count == 1) return 0;
  float total = 0;
  for (int m = 0; m < count; ++m) total += out[members[m]];
  const float scale = 1.0f / static_cast<float>(count);
  const float variance = total * (0.5f * scale * scale);
  for (int first = 0; first < stride; first += native_width) {
    (RowPack::load(out + first) * RowPack(scale) - RowPack(variance)).store(out + first);
  }
  return variance;
}

inline void lower_rows(const float* distances, int stride, float* least, float* sums) {
  for (int lane = 0; lane < row_lanes; lane += native_width) {
    RowPack sum(0.0f);
    for (int first = lane; first < stride; first += row_lanes) {
      const RowPack lower = min(RowPack::load(distances + first), RowPack::load(least + first));
      lower.store(least + first);
      sum = sum + lower;
    }
    sum.store(sums + lane);
  }
}

RowKernels make_row_kernels() {
  return {row_distances, nearest_points, centroid_distances, lower_rows};
}

}  // namespace relume::RELUME_ISA
