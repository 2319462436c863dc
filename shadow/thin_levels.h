#pragma once

#include "shadow/thin_geometry.h"

namespace relume {

/// Coarser forms of a shape of triangles, each with about half of the last one's, while its pieces
/// have any to give: vertices are taken out one at a time, the one that moves the surface least
/// first, borders along borders. Areas are kept by opacity, piece by piece, up to a factor of two.
/// Pieces of more than 512 triangles stay as they are. A chunk's error bounds how far, in local
/// units, vertices that were taken out lie from what is left of their piece.
std::vector<ThinLevel> make_levels(const ThinShape& shape);

}  // namespace relume
