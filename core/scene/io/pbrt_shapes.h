#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/scene/io/indexed_mesh.h"
#include "core/scene/io/pbrt_text.h"

namespace relume {

/// The triangles of a Shape "trianglemesh", "plymesh", "bilinearmesh", "loopsubdiv" (not
/// subdivided), "sphere" (whole) or "disk"; nothing for other shapes. `folder` is the scene's.
/// Indices are within the positions. Throws Error(input) as "FILE:LINE: ...".
std::optional<IndexedMesh> read_pbrt_mesh(const PbrtStatement& shape,
                                          const std::filesystem::path& folder);

/// The points and radii of a Shape "curve", Bezier or B-spline of degree 2 or 3, as a line of
/// segments that bend by less than 0.2 radians each, at most 16 a span.
std::vector<vec4> read_pbrt_curve(const PbrtStatement& shape);

}  // namespace relume
