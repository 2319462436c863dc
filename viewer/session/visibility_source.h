#pragma once

#include <memory>

#include "viewer/session/frame_source.h"

namespace relume {

/// Pictures of what a light reaches: RelitFrame::image is pixel_visibility() of the request's first
/// light under the request's shadows (none: those of ShadowMethod::ray), one channel. Cache and
/// tracer must outlive the source.
std::unique_ptr<FrameSource> make_visibility_source(const RelightCache& cache,
                                                    const Tracer& tracer);

}  // namespace relume
