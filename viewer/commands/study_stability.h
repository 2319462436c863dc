#pragma once

#include "viewer/commands/study_files.h"
#include "viewer/study/trial_log.h"

namespace relume {

/// The study `stability`: extremes against the double reference. Prints a table unless JSON is
/// asked for.
StudyResult run_stability_study(const StudyOptions& options, const CommonOptions& common,
                                TrialLog& log);

}  // namespace relume
