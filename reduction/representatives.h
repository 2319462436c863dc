#pragma once

#include <span>
#include <vector>

#include "core/base/random.h"
#include "core/math/vec.h"
#include "reduction/features.h"

namespace relume {

// The parts of TR2007-600's Light Metrics (sec. 3.2 to 3.5), each on plain matrices. Decisions
// where the report is silent are named at each. Squares of colours are summed over r, g and b.

/// The values of one type's samples in a pixel under the training lights, a row a sample: r, g and
/// b under l lights, so that a row is the report's row of V. Columns of zeros do no harm.
struct ValueRows {
  const float* values = nullptr;
  int rows = 0;
  int length = 0;  ///< floats per row; 3 l, or more with padding

  const float* row(int i) const { return values + static_cast<size_t>(i) * length; }
};

/// Eq. 4 times 3 l, for each row: how far the sample, alone, is from the whole pixel. `target` is
/// the pixel's own row: the sum over all its samples, of every type, over s, so that misses are
/// black.
void eval_errors(const ValueRows& v, const float* target, std::vector<float>& errors);

/// Sec. 3.2: the k rows of least error, best first, ties to the lower row. k <= rows.
std::vector<int> closest_rows(std::span<const float> errors, int k);

/// Sec. 3.3: the shader group of each row, numbered by creation, from its mean colour over all
/// lights. Rows are met in sampling order; each joins the first group whose colour, the running
/// mean of its members, lies within 30 degrees and less than sqrt(3) / 5 away in scene-linear RGB,
/// else it founds one. Angles are compared as cosines. Black has no angle: black to black counts as
/// the same direction, black to anything else as another.
std::vector<int> make_shader_groups(std::span<const vec3> mean_colors);

/// Sec. 3.3: k representatives, each the remaining sample of least error from a group drawn with
/// probability P_SG (eq. 5). P_SG stays that of the whole groups; a group once emptied is skipped:
/// the draw is among the others, in proportion. Ties to the lower row. k <= rows.
std::vector<int> draw_from_groups(std::span<const int> groups, std::span<const float> errors, int k,
                                  Random& random);

/// Sec. 3.5: k representatives, each the row that brings R, the plain mean of the representatives
/// and itself, closest to `target` (eq. 6); the first is that of eq. 4. Ties to the lower row. R
/// belongs to one type, as the text says ("as in section 3.2", which is per type). k <= rows.
std::vector<int> greedy_rows(const ValueRows& v, const float* target, int k);

/// Sec. 3.2: every row joins the representative nearest in parameter space (Euclidean distance of
/// `features`, the raw ones in the report), ties to the representative chosen first. Centroids are
/// not recalculated. A representative that equals an earlier one gets no members and is dropped.
Clustering assign_to_representatives(const Features& features,
                                     std::span<const int> representatives);

/// Sec. 3.4 and 3.7: each cluster's member of least error becomes its representative, ties to the
/// lower row.
void choose_representatives(std::span<const float> errors, Clustering& clustering);

}  // namespace relume
