#pragma once

#include <span>

#include "core/math/vec.h"
#include "core/samples/record_layout.h"
#include "core/scene/scene.h"

namespace relume {

/// Axes along and across the camera's line of sight, unit and orthogonal.
ViewAxes make_view_axes(const Camera& camera);

using BlockFrame = std::array<float, block_frame_floats>;

/// The frame that a block's packed records share, around their positions; zeros for none. Positions
/// lie in front of the eye.
BlockFrame make_block_frame(const ViewAxes& axes, std::span<const vec3> positions);

/// The bias that a record needs in a packed format: twice what rounding moves its position more
/// than `bias`, so that it does not shadow itself.
float packed_bias(const RecordLayout& layout, const BlockFrame& frame, const ViewAxes& axes,
                  vec3 position, float bias);

/// Writes one record of a packed format to words[0, layout.words). `values` is the sample vector,
/// whose colours get `weight`, > 0, and whose position is one of the frame's. Colours above
/// 4088 are clamped and counted (rare event).
void encode_record(const RecordLayout& layout, const float* values, float weight,
                   const BlockFrame& frame, const ViewAxes& axes, uint32_t* words);

/// The point of the square [-1, 1]^2 that an octahedron around the unit sphere unfolds `direction`
/// to (Cigolle et al. 2014).
vec2 fold_octahedron(vec3 direction);

}  // namespace relume
