#pragma once

#include <vector>

#include "core/relight/visibility.h"
#include "core/samples/relight_cache.h"

namespace relume {

/// Asks `source` for the visibility of every record of a block: 16 values a slot, in slot order,
/// into `visibility` (resized). `records`: the block as BlockDecoder shows it.
void query_block(const CacheInfo& info, const PackedBlock& block, const float* records,
                 const VisibilitySource& source, std::vector<float>& visibility);

}  // namespace relume
