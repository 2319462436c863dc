#pragma once

#include <atomic>
#include <optional>
#include <span>
#include <vector>

#include "core/image/image.h"
#include "core/relight/layer.h"
#include "core/relight/visibility.h"
#include "core/samples/relight_cache.h"
#include "core/simd/instruction_set.h"

namespace relume {

struct RelightParams {
  InstructionSet instruction_set = InstructionSet::automatic;
  /// Pixels that lights that changed are shaded for, not `none`; the others are filled in from
  /// their neighbours (see fill_pixels). A later call with a larger share adds the pixels that are
  /// missing, whose values do not depend on the way there.
  PixelShare pixels = PixelShare::all;
  /// The light that changed is expected to change again: the weighted sum of the others is kept, so
  /// that such frames cost the same whatever their number. It is added last, which rounds
  /// differently, by at most 2^-23 times the number of lights; a call without `dragging` sums in
  /// the order of the lights.
  bool dragging = false;
  /// Asked tile by tile, from any thread: once it is true the call throws Error(cancelled) as soon
  /// as it can. The frame is then of no use; layers that were complete stay, and the others hold
  /// what they held before. Null: never.
  const std::atomic<bool>* cancelled = nullptr;
};

/// What one relight() call did.
struct RelightStats {
  int layers_shaded = 0;         ///< lights whose layer was computed anew or completed
  uint64_t records_shaded = 0;   ///< records x layers; where not all pixels were shaded or lights
                                 ///< missed tiles, estimated from the bytes that were read
  uint64_t tiles_missed = 0;     ///< tiles x layers that were left out: the light cannot reach them
  uint64_t replaced_values = 0;  ///< non-finite values that were replaced by 0
  double prepare_ms = 0;         ///< VisibilitySource::prepare
  double shade_ms = 0;    ///< shading and visibility of the changed layers; where layers changed,
                          ///< with the weighted sum, which is made on the way
  double combine_ms = 0;  ///< weighted sum of the layers, when made by itself
};

/// The one mutable state of relighting: a layer per light and their weighted sum. A layer is the
/// response to its light at weight 1; the frame is sum_i lights[i].weight() * layers[i].
struct RelightState {
  const RelightCache* cache = nullptr;  ///< must outlive the state
  std::vector<Light> lights;            ///< those of the last relight()
  Image frame;                          ///< beauty, RGB, scene-linear, finite

  // For relight() alone.
  LayerLayout layout;
  std::vector<Layer> layers;        ///< parallel to lights
  Layer others;                     ///< weighted sum of all lights but one
  std::optional<size_t> others_of;  ///< that one; empty: `others` is not valid
  std::vector<Bounds> tile_bounds;  ///< made when a light comes that may miss a tile
};

RelightState make_relight_state(const RelightCache& cache);

/// Brings state.frame up to date with `lights`. Only layers whose light moved (see same_layer) are
/// shaded, those without shadows in one pass over the records; gain, colour and mute cost a
/// weighted sum. Tiles that a light cannot reach are left out. `shadows` null: everything is
/// visible. Lights are validated (Error(input) names the light and the field) before anything
/// changes. The frame is bit-equal for any thread count. Call invalidate() after exchanging the
/// shadow method.
RelightStats relight(RelightState& state, std::span<const Light> lights, VisibilitySource* shadows,
                     const RelightParams& params = {});

/// Forgets all layers: the next relight() shades every light.
void invalidate(RelightState& state);

/// Forgets the layer of light i, if it is there.
void invalidate(RelightState& state, size_t i);

/// The response to light i at weight 1, RGB; black where it is muted and was not shaded.
Image layer_image(const RelightState& state, size_t i);

/// The contribution of light i to the frame: its layer times its weight.
Image weighted_layer(const RelightState& state, size_t i);

/// Bytes that the layers take, beside the frame's.
size_t layer_bytes(const RelightState& state);

}  // namespace relume
