#pragma once

namespace relume {

/// The squared Euclidean distance of two rows of `count` floats. Sixteen partial sums, then the
/// rest, in a fixed order: the compiler vectorises it and the result is the same on every machine.
inline float squared_distance(const float* a, const float* b, int count) {
  constexpr int lanes = 16;
  float partial[lanes] = {};
  int i = 0;
  for (; i + lanes <= count; i += lanes) {
    for (int lane = 0; lane < lanes; ++lane) {
      const float d = a[i + lane] - b[i + lane];
      partial[lane] += d * d;
    }
  }
  float sum = 0;
  if (i > 0) {
    for (const float value : partial) sum += value;
  }
  for (; i < count; ++i) {
    const float d = a[i] - b[i];
    sum += d * d;
  }
  return sum;
}

}  // namespace relume
