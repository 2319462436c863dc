#pragma once

#include "core/samples/sample_tile.h"
#include "core/trace/pixel_sampler.h"
#include "core/trace/tracer.h"

namespace relume {

/// A material's value for one of its shader's parameters.
struct ResolvedParameter {
  vec3 value{0};
  int texture = -1;           ///< index into Scene::textures, multiplies the value, or -1
  int channel = -1;           ///< of the texture; -1: red, green and blue
  bool strand_color = false;  ///< multiplied by the strand's own colour
};

/// Everything that sampling a view needs; built once, then read by all threads.
struct ViewSampler {
  const Scene* scene;
  const Tracer* tracer;
  SampleTypes types;
  CameraRays rays;
  PixelStrata strata;
  uint64_t seed;
  int width;                                               ///< pixels
  int height;                                              ///< pixels
  std::vector<std::vector<ResolvedParameter>> parameters;  ///< per material, as material_parameters
  bool emits = false;                                      ///< has_emission(scene)
};

ViewSampler make_view_sampler(const Scene& scene, const Tracer& tracer, int width, int height,
                              int spp, uint64_t seed);

/// Number of tiles of the view, row by row.
int tile_count(const ViewSampler& view);

/// Where tile `index` of the view lies; pixels.
struct TileRectangle {
  int x0 = 0;
  int y0 = 0;
  int width = 0;
  int height = 0;
};
TileRectangle tile_rectangle(const ViewSampler& view, int index);

/// Samples tile `index` of the view: traces strata.spp rays a pixel and turns each hit into the
/// sample vector of its material's type, with textures baked in, weight 1 / spp. Misses leave
/// nothing: they only lower the coverage. Every stored value is finite; a hit that would break that
/// is dropped and counted. A function of (scene, view, index) alone.
SampleTile sample_tile(const ViewSampler& view, int index);

/// Per type and row of a tile, the stratum that the sample lies in: which of the pixel's cells, in
/// scanline order.
using SampleCells = std::vector<std::vector<uint16_t>>;

/// The same, and where within their pixels the samples lie.
SampleTile sample_tile(const ViewSampler& view, int index, SampleCells& cells);

/// The same for the single pixel (x, y), as a tile of one pixel: bit-equal to its part of the tile.
SampleTile sample_one_pixel(const ViewSampler& view, int x, int y);

}  // namespace relume
