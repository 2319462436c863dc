#include "reduction/representatives.h"

#include <limits>
#include <numeric>

#include "core/base/check.h"
#include "reduction/distance.h"

namespace relume {
namespace {

/// A shader group while rows are being sorted into groups.
struct ShaderGroup {
  dvec3 sum;
  int members;
};

bool belongs(dvec3 color, dvec3 group) {
  static const double cos_limit = std::sqrt(3.0) / 2;  // 30 degrees
  static const double distance_limit = std::sqrt(3.0) / 5;
  const double lengths = glm::length(color) * glm::length(group);
  const bool both_black = color == dvec3(0) && group == dvec3(0);
  const bool same_direction = both_black || glm::dot(color, group) > cos_limit * lengths;
  return same_direction && glm::distance(color, group) < distance_limit;
}

/// The squared distance of (sum + row) * scale from target, in the partial sums of
/// squared_distance.
float mean_distance(const float* sum, const float* row, float scale, const float* target,
                    int length) {
  constexpr int lanes = 16;
  float partial[lanes] = {};
  int i = 0;
  for (; i + lanes <= length; i += lanes) {
    for (int lane = 0; lane < lanes; ++lane) {
      const float d = (sum[i + lane] + row[i + lane]) * scale - target[i + lane];
      partial[lane] += d * d;
    }
  }
  float result = 0;
  for (const float value : partial) result += value;
  for (; i < length; ++i) {
    const float d = (sum[i] + row[i]) * scale - target[i];
    result += d * d;
  }
  return result;
}

/// The row of `group` with the least error that is not yet taken.
int best_of_group(std::span<const int> groups, std::span<const float> errors,
                  const std::vector<bool>& taken, int group) {
  int best = -1;
  for (int row = 0; row < static_cast<int>(groups.size()); ++row) {
    if (groups[row] != group || taken[row]) continue;
    if (best < 0 || errors[row] < errors[best]) best = row;
  }
  CHECK_MSG(best >= 0, "group {}", group);
  return best;
}

}  // namespace

void eval_errors(const ValueRows& v, const float* target, std::vector<float>& errors) {
  errors.resize(v.rows);
  for (int row = 0; row < v.rows; ++row) {
    errors[row] = squared_distance(v.row(row), target, v.length);
  }
}

std::vector<int> closest_rows(std::span<const float> errors, int k) {
  CHECK_MSG(k <= static_cast<int>(errors.size()), "k {} rows {}", k, errors.size());
  std::vector<int> rows(errors.size());
  std::iota(rows.begin(), rows.end(), 0);
  std::stable_sort(rows.begin(), rows.end(), [&](int a, int b) { return errors[a] < errors[b]; });
  rows.resize(k);
  return rows;
}

std::vector<int> make_shader_groups(std::span<const vec3> mean_colors) {
  std::vector<ShaderGroup> groups;
  std::vector<int> group_of;
  for (const vec3 mean_color : mean_colors) {
    const dvec3 color(mean_color);
    const auto found = std::find_if(groups.begin(), groups.end(), [&](const ShaderGroup& group) {
      return belongs(color, group.sum / static_cast<double>(group.members));
    });
    group_of.push_back(static_cast<int>(found - groups.begin()));
    if (found == groups.end()) {
      groups.push_back({color, 1});
    } else {
      found->sum += color;
      ++found->members;
    }
  }
  return group_of;
}

std::vector<int> draw_from_groups(std::span<const int> groups, std::span<const float> errors, int k,
                                  Random& random) {
  CHECK_MSG(k <= static_cast<int>(groups.size()), "k {} rows {}", k, groups.size());
  const int group_count = groups.empty() ? 0 : *std::max_element(groups.begin(), groups.end()) + 1;
  std::vector<uint32_t> sizes(group_count, 0);
  for (const int group : groups) ++sizes[group];
  std::vector<uint32_t> left = sizes;
  auto total = static_cast<uint32_t>(groups.size());
  std::vector<bool> taken(groups.size(), false);
  std::vector<int> chosen;
  while (static_cast<int>(chosen.size()) < k) {
    uint32_t draw = random.below(total);
    int group = 0;
    while (left[group] == 0 || draw >= sizes[group]) {
      if (left[group] > 0) draw -= sizes[group];
      ++group;
    }
    const int row = best_of_group(groups, errors, taken, group);
    taken[row] = true;
    chosen.push_back(row);
    if (--left[group] == 0) total -= sizes[group];
  }
  return chosen;
}

std::vector<int> greedy_rows(const ValueRows& v, const float* target, int k) {
  CHECK_MSG(k <= v.rows, "k {} rows {}", k, v.rows);
  std::vector<float> sum(v.length, 0.0f);  // R times the number of representatives
  std::vector<bool> taken(v.rows, false);
  std::vector<int> chosen;
  while (static_cast<int>(chosen.size()) < k) {
    const float scale = 1.0f / static_cast<float>(chosen.size() + 1);
    int best = -1;
    float least = 0;
    for (int row = 0; row < v.rows; ++row) {
      if (taken[row]) continue;
      const float error = mean_distance(sum.data(), v.row(row), scale, target, v.length);
      if (best >= 0 && !(error < least)) continue;
      best = row;
      least = error;
    }
    taken[best] = true;
    chosen.push_back(best);
    for (int i = 0; i < v.length; ++i) sum[i] += v.row(best)[i];
  }
  return chosen;
}

Clustering assign_to_representatives(const Features& features,
                                     std::span<const int> representatives) {
  CHECK(!representatives.empty());
  const auto distance = [&](int row, int representative) {
    return squared_distance(features.row(row), features.row(representative), features.dimensions);
  };
  std::vector<int> nearest(features.rows, 0);
  std::vector<int> renumbered(representatives.size(), -1);
  for (int row = 0; row < features.rows; ++row) {
    float least = distance(row, representatives[0]);
    for (int i = 1; i < static_cast<int>(representatives.size()); ++i) {
      const float d = distance(row, representatives[i]);
      if (!(d < least)) continue;
      least = d;
      nearest[row] = i;
    }
    renumbered[nearest[row]] = 0;
  }
  Clustering result;
  for (size_t i = 0; i < representatives.size(); ++i) {
    if (renumbered[i] < 0) continue;
    renumbered[i] = result.count();
    result.representatives.push_back(representatives[i]);
  }
  for (const int i : nearest) result.cluster_of.push_back(renumbered[i]);
  return result;
}

void choose_representatives(std::span<const float> errors, Clustering& clustering) {
  std::fill(clustering.representatives.begin(), clustering.representatives.end(), -1);
  for (int row = 0; row < static_cast<int>(clustering.cluster_of.size()); ++row) {
    int& representative = clustering.representatives[clustering.cluster_of[row]];
    if (representative < 0 || errors[row] < errors[representative]) representative = row;
  }
}

}  // namespace relume
