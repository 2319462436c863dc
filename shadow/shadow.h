#pragma once

#include <array>
#include <memory>

#include "core/base/label.h"
#include "core/relight/visibility.h"
#include "core/trace/tracer.h"

namespace relume {

/// Shadow approximators. `none` sees every light from everywhere; `ray` traces one ray a receiver,
/// from its anchor (TR2007-600 sec. 4.2).
enum class ShadowMethod { none, ray };

inline constexpr std::array shadow_method_labels = {
    Label<ShadowMethod>{ShadowMethod::none, "none"},
    Label<ShadowMethod>{ShadowMethod::ray, "ray"},
};

/// The approximator for `method`, or null for `none`. Keeps a reference to the tracer.
std::unique_ptr<VisibilitySource> make_shadow(ShadowMethod method, const Tracer& tracer);

}  // namespace relume
