#pragma once

#include "viewer/commands/study_files.h"

namespace relume {

/// The studies `pictures` (TR2007-600 figures 1 and 8 to 13) and `smooth` (figure 3): scenes under
/// their own lights, all samples beside reduced records, and maps of the error. A few minutes; not
/// resumed. Prints a table unless JSON is asked for.
StudyResult run_picture_study(const StudyOptions& options, const CommonOptions& common);

}  // namespace relume
