#pragma once

#include <string>
#include <vector>

#include "core/image/image.h"
#include "core/samples/relight_cache.h"
#include "core/scene/light.h"
#include "core/trace/tracer.h"

namespace relume {

/// The colour that stands for sample type `type` in type_map(); sRGB-encoded.
vec3 type_color(size_t type);

/// Each pixel in the colour of the type that most of its weight belongs to; black where there is no
/// geometry. RGB, sRGB-encoded, in [0, 1].
Image type_map(const RelightCache& cache);

/// The mean normal of each pixel's records, or tangent on strands, as 0.5 + 0.5 n; black where
/// there is no geometry. RGB, in [0, 1], not to be tone mapped.
Image normal_map(const RelightCache& cache);

/// One record of a pixel.
struct InspectedRecord {
  std::string type;
  float weight = 0;  ///< 1 in packed formats, whose colours hold it
  vec3 position{0};  ///< world
  vec3 radiance{0};  ///< under all lights, weight included
};

/// What a pixel is made of.
struct PixelReport {
  float coverage = 0;  ///< in [0, 1]
  std::vector<InspectedRecord> records;
  std::vector<vec3> light_values;  ///< what each light adds to the pixel, scene-linear
  vec3 emission{0};                ///< what its materials add by themselves
};

/// Takes a pixel apart, in double precision. With a tracer each record's shadow is traced from its
/// position (ShadowMethod::ray). `x`, `y` lie within the picture.
PixelReport inspect_pixel(const RelightCache& cache, const Tracer* tracer,
                          std::span<const Light> lights, int x, int y);

}  // namespace relume
