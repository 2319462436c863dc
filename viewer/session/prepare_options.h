#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/samples/record_layout.h"
#include "core/samples/relight_cache.h"
#include "reduction/budget.h"
#include "reduction/reduction.h"
#include "shadow/shadow.h"
#include "viewer/session/view_state.h"

namespace relume {

/// How a scene becomes records, where a command is given a scene instead of a cache.
struct PrepareOptions {
  int spp = 25;
  ReductionMethod method = ReductionMethod::strong_kmeans;
  std::optional<int> records;  ///< k; default 8, or at most 16 under a budget
  RecordBudget budget;
  std::optional<int> members;  ///< positions kept of what a record stands for; default 0
  bool predict_error = false;
  /// Nothing: exact, or chosen for frame_ms or the budget's target error.
  std::optional<CacheFormat> format;
  float frame_ms = 0;  ///< > 0: records and format are chosen so that a move takes no longer
  ShadowMethod frame_shadows = ShadowMethod::none;  ///< that this time pays for
  int training_lights = 200;
  bool train_shadows = false;
  ReductionPreset preset = ReductionPreset::standard;
  int width = 0;  ///< pixels; 0 = the scene's
  int height = 0;
};

/// The flags with which `relume render` prepares as `options` and `seed` say; those that would only
/// repeat a default are left out.
std::vector<std::string> prepare_flags(const PrepareOptions& options, uint64_t seed);

/// `options` where a time chose records and format: with those instead, so that asking again needs
/// no clock. Pixels may then share their records out a little differently.
PrepareOptions chosen_options(PrepareOptions options, const CacheInfo& info);

/// `options` with records that were chosen later, if any were.
PrepareOptions with_records(PrepareOptions options, const RecordChoice& records);

/// How a cache was prepared, as far as it tells; nothing where its samples were not reduced.
std::optional<PrepareOptions> options_of(const CacheInfo& info);

/// One argument of a shell command: as it is, or in single quotes where a shell would read more
/// into it.
std::string shell_quoted(const std::string& argument);

}  // namespace relume
