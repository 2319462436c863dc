#pragma once

#include <vector>

#include "core/relight/visibility.h"
#include "core/samples/relight_cache.h"

namespace relume {

/// Asks `source` for the visibility of every record of a block: 16 values a slot, in slot order,
/// into `visibility` (resized).
void query_block(const CacheInfo& info, const PackedBlock& block, const VisibilitySource& source,
                 std::vector<float>& visibility);

}  // namespace relume
