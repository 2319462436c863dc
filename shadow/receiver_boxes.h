#pragma once

#include <vector>

#include "core/relight/receivers.h"

namespace relume {

/// World bounds of the receivers of each tile that has any: what maps from a light are fitted to.
std::vector<Bounds> receiver_boxes(const ViewReceivers& view);

}  // namespace relume
