#pragma once

#include "shadow/thin_geometry.h"

namespace relume {

/// At most six coarser forms of a shape of triangles, each with about half of the last one's, while
/// its pieces have any to give: vertices are taken out one at a time, the one that moves the
/// surface least first, borders along borders. A piece keeps 0.7 of its area or more, and opacity
/// makes up for the rest. Pieces of more than 512 triangles stay as they are. A piece's error is
/// how far, in local units, vertices that were taken out lie from what is left of it, or what is
/// left lies from where it was, whichever is more: the sum over the steps, an estimate from each
/// step's neighbourhood.
std::vector<ThinLevel> make_levels(const ThinShape& shape);

}  // namespace relume
