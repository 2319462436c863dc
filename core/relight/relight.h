#pragma once

#include <span>
#include <vector>

#include "core/image/image.h"
#include "core/relight/visibility.h"
#include "core/samples/relight_cache.h"
#include "core/simd/instruction_set.h"

namespace relume {

struct RelightParams {
  InstructionSet instruction_set = InstructionSet::automatic;
};

/// What one relight() call did.
struct RelightStats {
  int layers_shaded = 0;         ///< lights whose layer was computed anew
  uint64_t records_shaded = 0;   ///< records x layers, padding excluded
  uint64_t replaced_values = 0;  ///< non-finite pixel values that the film replaced by 0
  double prepare_ms = 0;         ///< VisibilitySource::prepare
  double shade_ms = 0;    ///< shading and visibility of the changed layers; where the last of them
                          ///< has no shadows, the weighted sum, too, which is made on the way
  double combine_ms = 0;  ///< weighted sum of the layers, when made by itself
};

/// The one mutable state of relighting: a layer per light and their weighted sum. A layer is the
/// response to its light at weight 1; the frame is sum_i lights[i].weight() * layers[i].
struct RelightState {
  const RelightCache* cache = nullptr;  ///< must outlive the state
  std::vector<Light> lights;            ///< those of the last relight()
  std::vector<Image> layers;            ///< parallel to lights, RGB
  Image frame;                          ///< beauty, RGB, scene-linear, finite
};

RelightState make_relight_state(const RelightCache& cache);

/// Brings state.frame up to date with `lights`. Only layers whose light moved (see same_layer) are
/// shaded, those without shadows in one pass over the records; gain, colour and mute cost a
/// weighted sum. `shadows` null: everything is visible. Lights are validated (Error(input) names
/// the light and the field) before anything changes. The frame is bit-equal for any thread count.
/// Call invalidate() after exchanging the shadow method.
RelightStats relight(RelightState& state, std::span<const Light> lights, VisibilitySource* shadows,
                     const RelightParams& params = {});

/// Forgets all layers: the next relight() shades every light.
void invalidate(RelightState& state);

/// The contribution of light i to the frame: layers[i] times its weight.
Image weighted_layer(const RelightState& state, size_t i);

}  // namespace relume
