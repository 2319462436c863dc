#pragma once

#include "viewer/commands/study_files.h"
#include "viewer/study/trial_log.h"

namespace relume {

/// The study `shadows`: shadow approximators against the truth, by scene and light. Prints tables
/// unless JSON is asked for.
StudyResult run_shadow_study(const StudyOptions& options, const CommonOptions& common,
                             TrialLog& log);

}  // namespace relume
