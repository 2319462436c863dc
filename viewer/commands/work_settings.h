#pragma once

#include <string>

#include "core/scene/scene.h"
#include "viewer/commands/options.h"

namespace relume {

/// A hash of the program itself: results of another build are not taken over. "unknown" where the
/// system does not say.
std::string hash_program();

/// All that what this command makes of `scene` depends on, as text: the program, its command line,
/// the scene and its geometry.
std::string describe_work(const CommonOptions& common, const Scene& scene);

}  // namespace relume
