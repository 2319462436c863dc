#pragma once

#include "viewer/commands/study_files.h"
#include "viewer/study/trial_log.h"

namespace relume {

/// The studies that compare reduction methods: `methods`, `rates` and `lights`, by options.name.
/// Prints a table a scene unless JSON is asked for. Tables: "rows", a method, k and kind of shadow
/// each; "pairs", every two methods under the same lights. Raw: "trials", the error under each
/// light.
StudyResult run_method_study(const StudyOptions& options, const CommonOptions& common,
                             TrialLog& log);

}  // namespace relume
