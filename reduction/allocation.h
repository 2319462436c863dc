#pragma once

#include <span>
#include <vector>

namespace relume {

/// k_t: how many of a pixel's k records each type gets, in proportion to its samples (TR2007-600
/// sec. 3). The report leaves rounding open; here by largest remainder, ties to the type with more
/// samples, then to the lower index. k_t <= n_t; sum k_t = min(k, sum n_t).
///
/// `keep_types`: every type whose share k n_t / n is at least an eighth of a record gets one as
/// long as k allows (largest types first), taken from the types with most to spare. Below an eighth
/// the record does more for the others (docs/reduction.md). The report does not do this and loses
/// rare types.
std::vector<int> allocate_records(std::span<const int> samples_per_type, int k, bool keep_types);

}  // namespace relume
