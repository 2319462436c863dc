#pragma once

#include "viewer/commands/study_files.h"
#include "viewer/study/trial_log.h"

namespace relume {

/// The study `tradeoff`: error against milliseconds a light move. Prints what it recommends unless
/// JSON is asked for. Tables: "rows", a setting each; "recommended", by scene and time.
StudyResult run_tradeoff_study(const StudyOptions& options, const CommonOptions& common,
                               TrialLog& log);

}  // namespace relume
