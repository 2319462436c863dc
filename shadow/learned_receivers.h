#pragma once

#include <vector>

#include "core/relight/receivers.h"

namespace relume {

/// The receivers of a view as the rasteriser wants them, in a space where all lie within the unit
/// sphere: p = (world - center) / scale. Padding is left out. A receiver whose samples lie far from
/// each other counts as several, its spots, which follow each other.
struct LearnedReceivers {
  dvec3 center{0};
  double scale = 1;
  std::vector<float> position[3];    ///< mean of the spot's samples
  std::vector<float> normal[3];      ///< zero on strands
  std::vector<float> covariance[6];  ///< xx, xy, xz, yy, yz, zz, with the cell below
  std::vector<float> bias;           ///< how far towards the light occluders do not count
  std::vector<float> margin;         ///< see CoverageReceivers
  std::vector<uint8_t> one_sided;    ///< 1: light from behind the normal does not count
  std::vector<float> share;          ///< the spot's part of its receiver's samples
  std::vector<uint32_t> index;       ///< of the receiver, in the cache's order
  std::vector<size_t> tile_first;    ///< spots of each tile of the cache start here; and the end

  size_t count() const { return index.size(); }
};

/// Samples of a receiver form one spot while they are within one pixel of its first one, on strands
/// half a pixel, and their normals within 60 degrees; where the view has no members the footprint
/// is the spot.
///
/// A sample stands for its cell of the picture, a pixel over the samples in it, seen on the surface
/// along the line of sight; the cell is added to each footprint, which is the spread of points.
LearnedReceivers learn_receivers(const ViewReceivers& view);

}  // namespace relume
