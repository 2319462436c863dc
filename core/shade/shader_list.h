#pragma once

#include "core/shade/ggx.h"
#include "core/shade/kajiya_kay.h"
#include "core/shade/lambert.h"
#include "core/shade/leaf.h"
#include "core/shade/phong.h"

namespace relume {

template <class... Shaders>
struct ShaderList {};

/// The one place that names every shader. To add one, write its file and add it here.
using AllShaders = ShaderList<Lambert, Phong, KajiyaKay, Leaf, Ggx>;

}  // namespace relume
