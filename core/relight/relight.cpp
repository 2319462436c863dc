#include "core/relight/relight.h"

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/timer.h"
#include "core/relight/film.h"
#include "core/relight/kernel.h"
#include "core/relight/receivers.h"
#include "core/samples/sample_tile.h"
#include "core/shade/shaders.h"

namespace relume {
namespace {

/// What shading needs of a cache, gathered once per call.
struct CacheView {
  const RelightCache& cache;
  std::vector<int> shaders;  ///< per type
  std::vector<int> widths;   ///< per type
  ShadeBlock shade_block;
};

CacheView make_view(const RelightCache& cache, const RelightParams& params) {
  CacheView view{cache, {}, {}, block_kernel(choose_instruction_set(params.instruction_set))};
  const auto table = shader_table();
  for (const SampleType& type : cache.info().types) {
    const auto found = std::find(table.begin(), table.end(), type.shader);
    CHECK(found != table.end());
    view.shaders.push_back(static_cast<int>(found - table.begin()));
    view.widths.push_back(type.width);
  }
  return view;
}

/// Shades one block and hands its pixels to the film.
void shade_one_block(const CacheView& view, const PackedTile& tile, int index,
                     const KernelLight& light, const VisibilitySource* shadows,
                     std::vector<float>& visibility, Film& film) {
  const PackedBlock block = view.cache.block(tile, index);
  const CacheInfo& info = view.cache.info();
  if (shadows != nullptr) query_block(info, block, *shadows, visibility);
  alignas(64) float rgb[3 * block_lanes];
  const vec3 eye = info.camera.eye;
  view.shade_block({block.data,
                    block.slots,
                    view.shaders.data(),
                    view.widths.data(),
                    static_cast<int>(view.widths.size()),
                    shadows != nullptr ? visibility.data() : nullptr,
                    {eye.x, eye.y, eye.z},
                    rgb},
                   light);
  for (int lane = 0; lane < block.lanes; ++lane) {
    film.write(tile.x0 + block.pixels[lane] % tile_size, tile.y0 + block.pixels[lane] / tile_size,
               {rgb[lane], rgb[block_lanes + lane], rgb[2 * block_lanes + lane]});
  }
}

void shade_layer(const CacheView& view, const Light& light, const VisibilitySource* shadows,
                 Image& layer, RelightStats& stats) {
  const CacheInfo& info = view.cache.info();
  layer = Image(info.width, info.height);
  const KernelLight kernel_light = make_kernel_light(light, info.bounds.radius());
  Film film(layer);
  const auto tiles = view.cache.tiles();
  parallel_for(tiles.size(), shadows != nullptr ? 1 : 8, [&](size_t begin, size_t end) {
    std::vector<float> visibility;
    for (size_t t = begin; t < end; ++t) {
      for (int b = 0; b < tiles[t].block_count; ++b) {
        shade_one_block(view, tiles[t], b, kernel_light, shadows, visibility, film);
      }
    }
  });
  ++stats.layers_shaded;
  stats.records_shaded += info.record_count;
  stats.replaced_values += film.replaced();
}

/// frame = sum of weight * layer, in light order.
void combine_layers(RelightState& state, RelightStats& stats) {
  const int width = state.frame.width;
  std::vector<vec3> weights;
  for (const Light& light : state.lights) weights.push_back(light.weight());
  Film film(state.frame);
  parallel_for(static_cast<size_t>(state.frame.height), 16, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      for (int x = 0; x < width; ++x) {
        vec3 sum(0);
        for (size_t i = 0; i < weights.size(); ++i) {
          if (weights[i] == vec3(0)) continue;
          const float* p = state.layers[i].at(x, static_cast<int>(y));
          sum += weights[i] * vec3(p[0], p[1], p[2]);
        }
        film.write(x, static_cast<int>(y), sum);
      }
    }
  });
  stats.replaced_values += film.replaced();
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
  const CacheView view = make_view(*state.cache, params);
  RelightStats stats;
  // Kept in step light by light, so that an exception on the way leaves no layer of another light.
  state.lights.resize(std::min(state.lights.size(), state.layers.size()));
  const size_t known = state.lights.size();
  state.lights.resize(lights.size());
  state.layers.resize(lights.size());
  for (size_t i = 0; i < lights.size(); ++i) {
    const bool current =
        i < known && same_layer(state.lights[i], lights[i]) && state.layers[i].width > 0;
    // A muted light is not shaded: its layer waits until it is wanted.
    if (!current) state.layers[i] = Image();
    state.lights[i] = lights[i];
    if (current || lights[i].mute) continue;
    const bool shadowed = shadows != nullptr && lights[i].casts_shadow;
    const Timer prepare_timer;
    if (shadowed) shadows->prepare(lights[i]);
    stats.prepare_ms += prepare_timer.ms();
    const Timer shade_timer;
    Image layer;
    shade_layer(view, lights[i], shadowed ? shadows : nullptr, layer, stats);
    state.layers[i] = std::move(layer);
    stats.shade_ms += shade_timer.ms();
  }
  const Timer combine_timer;
  combine_layers(state, stats);
  stats.combine_ms = combine_timer.ms();
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
