#pragma once

#include <vector>

#include "core/base/bytes_of.h"
#include "core/relight/receivers.h"
#include "shadow/coverage_kernel.h"
#include "shadow/thin_geometry.h"

namespace relume {

/// A spot's part of a receiver.
struct ReceiverLink {
  uint32_t receiver;  ///< in the cache's order
  uint32_t spot;
  float share;  ///< of the receiver's samples
};

/// The receivers of a view as the rasteriser wants them: spots, which are one or several for each
/// receiver and may belong to several receivers of one pixel. Padding is left out.
struct LearnedReceivers {
  dvec3 center{0};  ///< spots are (world - center) / scale, within the unit sphere
  double scale = 1;
  std::vector<CoverageReceiver> spots;
  float mean_size = 0;              ///< of the spots: root of three times the covariance's trace
  std::vector<ReceiverLink> links;  ///< those of a receiver follow each other

  /// What belongs to a tile of the cache: first that of a quarter of its pixels, see PixelShare.
  struct Range {
    size_t first = 0;
    size_t quarter_end = 0;
    size_t all_end = 0;

    size_t end(PixelShare share) const { return share == PixelShare::all ? all_end : quarter_end; }
  };
  std::vector<Range> tile_spots;
  std::vector<Range> tile_links;

  size_t count() const { return spots.size(); }
  uint64_t memory_bytes() const { return bytes_of(spots, links, tile_spots, tile_links); }
};

/// On strands, samples of a receiver form one spot while they are within half a pixel of its first
/// one. On surfaces, samples of a pixel form one, whatever receivers they belong to, while they are
/// within 0.3 pixels on one piece of geometry or in one plane and their normals agree. Where the
/// view has no members a receiver's footprint is its spot, or where it is wider, its first sample.
///
/// A sample stands for its cell of the picture, a pixel over the samples in it, seen on the surface
/// along the line of sight; the cell is added to each footprint, which is the spread of points.
///
/// `tracer` finds the surface and the piece of `geometry` that each spot lies on; its scene is the
/// one that both were made from.
LearnedReceivers learn_receivers(const ViewReceivers& view, const Tracer& tracer,
                                 const ThinGeometry& geometry);

}  // namespace relume
