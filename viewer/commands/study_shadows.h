#pragma once

#include "viewer/commands/options.h"

namespace relume {

/// `relume study shadows`: shadow approximators against the truth, by scene and light.
int run_shadow_study(const StudyOptions& options, const CommonOptions& common);

}  // namespace relume
