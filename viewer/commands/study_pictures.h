#pragma once

#include "viewer/commands/study_files.h"
#include "viewer/study/trial_log.h"

namespace relume {

/// The studies `pictures` (TR2007-600 figures 1 and 8 to 13) and `smooth` (figure 3): scenes under
/// their own lights, all samples beside reduced records, and maps of the error. Pictures are
/// written as they are made. Prints a table unless JSON is asked for.
StudyResult run_picture_study(const StudyOptions& options, const CommonOptions& common,
                              TrialLog& log);

}  // namespace relume
