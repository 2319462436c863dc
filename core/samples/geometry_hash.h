#pragma once

#include "core/scene/scene.h"

namespace relume {

/// XXH3 over all of a scene that a shadow ray can meet: shapes, where they stand, and cut-outs.
/// Scenes of equal hashes cast equal shadows.
uint64_t geometry_hash(const Scene& scene);

}  // namespace relume
