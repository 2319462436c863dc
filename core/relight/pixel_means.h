#pragma once

#include <array>

#include "core/base/label.h"
#include "core/image/image.h"
#include "core/samples/relight_cache.h"

namespace relume {

/// What of a pixel's records is averaged: their positions (world), their normals (world; on strands
/// the direction across the strand that faces the eye), their diffuse colours.
enum class MeanField { position, normal, albedo };

/// The mean of a pixel's records, weighted by their weights and divided by the weights' sum, not by
/// coverage: edges keep the values of what covers them. Three channels; 0 where a pixel has no
/// records. Means of unit normals are shorter than 1. Packed formats keep no weights: there every
/// record counts alike for positions and normals, and albedo is exact to the 8 bits of coverage.
/// All threads; bit-equal for any number of them.
Image pixel_means(const RelightCache& cache, MeanField field);

}  // namespace relume
