#include "core/relight/relight.h"

#include <fmt/format.h>

#include <array>
#include <deque>
#include <memory>
#include <utility>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/timer.h"
#include "core/relight/film.h"
#include "core/relight/tile_shader.h"

namespace relume {
namespace {

/// Tiles that a thread takes at a time.
constexpr size_t tile_grain = 8;

/// A layer that is being shaded.
struct ChangedLayer {
  size_t light;  ///< index into the state's lights
  KernelLight kernel_light;
  Image image;  ///< a layer of the same cache: pixels of tiles without records are 0
};

/// Weights of a light for a row of a tile, as the frame's floats lie: r g b r g b ...
using RowWeights = std::array<float, 3 * tile_size>;

/// Layers and what they count for, of the lights that are not black.
struct Combination {
  std::vector<const Image*> layers;
  std::vector<RowWeights> weights;
};

/// Rows of a tile: frame = sum of weight * layer, in light order. `width` in pixels, or 0 when the
/// tile tells it: loops of constant length are faster.
template <int width>
void combine_rows(const Combination& combination, const PackedTile& tile, Film& film) {
  const int pixels = width > 0 ? width : tile.width;
  for (int y = tile.y0; y < tile.y0 + tile.height; ++y) {
    RowWeights sum{};
    for (size_t i = 0; i < combination.layers.size(); ++i) {
      const float* row = combination.layers[i]->at(tile.x0, y);
      const RowWeights& weights = combination.weights[i];
      for (int j = 0; j < 3 * pixels; ++j) sum[j] += weights[j] * row[j];
    }
    film.write_row(tile.x0, y, pixels, sum.data());
  }
}

void combine_tile(const Combination& combination, const PackedTile& tile, Film& film) {
  const auto combine = tile.width == tile_size ? combine_rows<tile_size> : combine_rows<0>;
  combine(combination, tile, film);
}

void write_tile(const float* rgbx, const PackedTile& tile, Film& film) {
  for (int y = 0; y < tile.height; ++y) {
    film.write_row_rgbx(tile.x0, tile.y0 + y, tile.width, rgbx + 4 * tile_size * y);
  }
}

/// Asks for what the kernels do not: the block headers.
void prefetch_headers(const PackedTile& tile) {
  const auto* end = reinterpret_cast<const std::byte*>(tile.coverage);
  for (const std::byte* line = tile.blocks; line < end; line += 64) __builtin_prefetch(line);
}

/// Shades tiles under layers, whose films are parallel to them.
void shade_tile(const TileShader& shader, const PackedTile& tile,
                std::span<const KernelLight> lights, const VisibilitySource* shadows,
                std::deque<Film>& films, TileScratch& scratch) {
  // Lights of one kind lie together.
  for (size_t first = 0; first < lights.size();) {
    size_t end = first + 1;
    while (end < lights.size() && end - first < max_kernel_lights &&
           lights[end].kind == lights[first].kind) {
      ++end;
    }
    shader.shade(tile, lights.subspan(first, end - first), shadows, scratch);
    for (size_t i = first; i < end; ++i) write_tile(scratch.rgbx[i - first], tile, films[i]);
    first = end;
  }
}

/// One pass over the records of all tiles, for layers that ask the same `shadows`. When
/// `combination` is given, each tile's part of the frame is summed as soon as its layers are done.
void shade_layers(const RelightState& state, const TileShader& shader,
                  std::span<ChangedLayer> changed, const VisibilitySource* shadows,
                  const Combination* combination, Film& frame, RelightStats& stats) {
  const auto tiles = state.cache->tiles();
  std::vector<KernelLight> lights;
  std::deque<Film> films;
  for (ChangedLayer& layer : changed) {
    lights.push_back(layer.kernel_light);
    films.emplace_back(layer.image);
  }
  parallel_for(tiles.size(), shadows != nullptr ? 1 : tile_grain, [&](size_t begin, size_t end) {
    const auto scratch = std::make_unique_for_overwrite<TileScratch>();
    for (size_t t = begin; t < end; ++t) {
      if (t + 1 < tiles.size()) prefetch_headers(tiles[t + 1]);
      if (tiles[t].block_count == 0) continue;
      shade_tile(shader, tiles[t], lights, shadows, films, *scratch);
      if (combination != nullptr) combine_tile(*combination, tiles[t], frame);
    }
  });
  const auto layers = static_cast<int>(changed.size());
  stats.layers_shaded += layers;
  stats.records_shaded += state.cache->info().record_count * static_cast<uint64_t>(layers);
  for (const Film& film : films) stats.replaced_values += film.replaced();
}

/// Brings state.lights up to date and takes out the layers that no longer hold, so that an
/// exception on the way leaves no layer of another light. A muted light is not shaded: its layer
/// waits until it is wanted.
std::vector<ChangedLayer> take_changed(RelightState& state, std::span<const Light> lights) {
  const CacheInfo& info = state.cache->info();
  state.lights.resize(std::min(state.lights.size(), state.layers.size()));
  const size_t known = state.lights.size();
  state.lights.resize(lights.size());
  state.layers.resize(lights.size());
  std::vector<ChangedLayer> changed;
  for (size_t i = 0; i < lights.size(); ++i) {
    const bool current =
        i < known && same_layer(state.lights[i], lights[i]) && state.layers[i].width > 0;
    state.lights[i] = lights[i];
    if (current) continue;
    Image image = std::exchange(state.layers[i], Image());
    if (lights[i].mute) continue;
    if (image.width == 0) image = Image(info.width, info.height);
    changed.push_back({i, make_kernel_light(lights[i], info.bounds.radius()), std::move(image)});
  }
  return changed;
}

/// Every light's layer, of which some are still in `changed`.
Combination make_combination(const RelightState& state, std::span<const ChangedLayer> changed) {
  Combination combination;
  for (size_t i = 0; i < state.lights.size(); ++i) {
    const vec3 weight = state.lights[i].weight();
    if (weight == vec3(0)) continue;
    const auto found = std::find_if(changed.begin(), changed.end(),
                                    [i](const ChangedLayer& layer) { return layer.light == i; });
    combination.layers.push_back(found != changed.end() ? &found->image : &state.layers[i]);
    RowWeights& row = combination.weights.emplace_back();
    for (size_t j = 0; j < row.size(); ++j) row[j] = weight[j % 3];
  }
  return combination;
}

void put_back(RelightState& state, std::span<ChangedLayer> changed) {
  for (ChangedLayer& layer : changed) state.layers[layer.light] = std::move(layer.image);
}

/// Shades the layers that ask `shadows`, one after the other: it is made ready for one light at a
/// time.
void shade_shadowed(RelightState& state, const TileShader& shader, std::span<ChangedLayer> changed,
                    VisibilitySource& shadows, Film& frame, RelightStats& stats) {
  for (ChangedLayer& layer : changed) {
    const Timer prepare_timer;
    shadows.prepare(state.lights[layer.light]);
    stats.prepare_ms += prepare_timer.ms();
    const Timer shade_timer;
    shade_layers(state, shader, {&layer, 1}, &shadows, nullptr, frame, stats);
    put_back(state, {&layer, 1});
    stats.shade_ms += shade_timer.ms();
  }
}

/// Shades the other layers in one pass and sums the frame on the way.
void shade_unshadowed(RelightState& state, const TileShader& shader,
                      std::span<ChangedLayer> changed, Film& frame, RelightStats& stats) {
  const Timer timer;
  std::stable_sort(changed.begin(), changed.end(),
                   [](const ChangedLayer& a, const ChangedLayer& b) {
                     return a.kernel_light.kind < b.kernel_light.kind;
                   });
  const Combination combination = make_combination(state, changed);
  shade_layers(state, shader, changed, nullptr, &combination, frame, stats);
  put_back(state, changed);
  stats.shade_ms += timer.ms();
}

void combine_layers(const RelightState& state, Film& frame, RelightStats& stats) {
  const Timer timer;
  const Combination combination = make_combination(state, {});
  const auto tiles = state.cache->tiles();
  parallel_for(tiles.size(), tile_grain, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      if (tiles[t].block_count > 0) combine_tile(combination, tiles[t], frame);
    }
  });
  stats.combine_ms += timer.ms();
}

}  // namespace

RelightState make_relight_state(const RelightCache& cache) {
  RelightState state;
  state.cache = &cache;
  state.frame = Image(cache.info().width, cache.info().height);
  return state;
}

RelightStats relight(RelightState& state, std::span<const Light> lights, VisibilitySource* shadows,
                     const RelightParams& params) {
  for (size_t i = 0; i < lights.size(); ++i) {
    validate_light(lights[i], fmt::format("lights/{} ({})", i, lights[i].name));
  }
  const TileShader shader(*state.cache, params.instruction_set);
  RelightStats stats;
  std::vector<ChangedLayer> changed = take_changed(state, lights);
  const auto unshadowed =
      std::stable_partition(changed.begin(), changed.end(), [&](const ChangedLayer& layer) {
        return shadows != nullptr && state.lights[layer.light].casts_shadow;
      });
  Film frame(state.frame);
  if (unshadowed != changed.begin()) {
    shade_shadowed(state, shader, {changed.begin(), unshadowed}, *shadows, frame, stats);
  }
  if (unshadowed != changed.end()) {
    shade_unshadowed(state, shader, {unshadowed, changed.end()}, frame, stats);
  } else {
    combine_layers(state, frame, stats);
  }
  stats.replaced_values += frame.replaced();
  return stats;
}

void invalidate(RelightState& state) {
  state.lights.clear();
  state.layers.clear();
}

Image weighted_layer(const RelightState& state, size_t i) {
  CHECK_MSG(i < state.layers.size(), "layer {} of {}", i, state.layers.size());
  Image result(state.frame.width, state.frame.height);
  if (state.layers[i].width == 0) return result;
  Film film(result);
  const vec3 weight = state.lights[i].weight();
  for (int y = 0; y < result.height; ++y) {
    for (int x = 0; x < result.width; ++x) {
      const float* p = state.layers[i].at(x, y);
      film.write(x, y, weight * vec3(p[0], p[1], p[2]));
    }
  }
  return result;
}

}  // namespace relume
