#pragma once

#include <span>
#include <string>

#include "core/scene/light.h"

namespace relume {

/// Lights as a UsdLux layer in text form (.usda), by the conventions of docs/frame-format.md.
std::string format_light_rig_usd(std::span<const Light> lights);

}  // namespace relume
