#include "core/relight/relight.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <memory>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/timer.h"
#include "core/relight/combine.h"
#include "core/relight/emission.h"
#include "core/relight/light_reach.h"
#include "core/relight/tile_shader.h"

namespace relume {
namespace {

RareEvent replaced_values("pixel values replaced: not finite");

/// Tiles that a thread takes at a time.
constexpr size_t tile_grain = 8;

/// A light whose layer is shaded.
struct Job {
  size_t light;  ///< index into the state's lights
  KernelLight kernel_light;
  PixelShare from;  ///< what the layer holds already
};

/// Jobs that one pass over the records does.
struct Pass {
  std::vector<Job> jobs;
  VisibilitySource* shadows = nullptr;
};

/// Counts of a pass, summed over threads.
struct PassCounts {
  std::atomic<uint64_t> words{0};
  std::atomic<uint64_t> tiles_missed{0};
  std::atomic<uint64_t> replaced{0};
};

/// Words of a tile's blocks in `range`.
uint64_t words_of(const RelightCache& cache, const PackedTile& tile, BlockRange range) {
  const auto end_of = [&](int b) {
    return b < tile.block_count ? cache.block(tile, b).words
                                : reinterpret_cast<const uint32_t*>(tile.blocks);
  };
  return range.first < range.end ? end_of(range.end) - end_of(range.first) : 0;
}

/// Asks for what the kernels do not: the block headers.
void prefetch_headers(const PackedTile& tile) {
  const auto* end = reinterpret_cast<const std::byte*>(tile.coverage);
  for (const std::byte* line = tile.blocks; line < end; line += 64) __builtin_prefetch(line);
}

/// Does passes over a state's tiles.
class LayerShader {
 public:
  LayerShader(RelightState& state, const TileShader& shader, const RelightParams& params,
              RelightStats& stats)
      : state_(state),
        cache_(*state.cache),
        shader_(shader),
        share_(params.pixels),
        cancelled_(params.cancelled),
        stats_(stats) {}

  /// Shades the pass's layers and, unless `combiner` is null, the frame.
  void run(const Pass& pass, const Combiner* combiner) {
    const auto tiles = cache_.tiles();
    PassCounts counts;
    parallel_for(tiles.size(), pass.shadows != nullptr ? 1 : tile_grain,
                 [&](size_t begin, size_t end) {
                   const auto scratch = std::make_unique<TileScratch>();
                   for (size_t t = begin; t < end; ++t) {
                     check_cancelled();
                     if (t + 1 < tiles.size()) prefetch_headers(tiles[t + 1]);
                     if (tiles[t].block_count == 0) continue;
                     if (combiner != nullptr) combiner->prefetch(t);
                     shade_tile(pass, t, *scratch, counts);
                     if (combiner != nullptr) counts.replaced += combiner->combine(t, *scratch);
                   }
                   shader_.kernels().finish_streams();
                 });
    for (const Job& job : pass.jobs) state_.layers[job.light].share = share_;
    record(pass, counts);
  }

  void check_cancelled() const {
    if (cancelled_ != nullptr && cancelled_->load(std::memory_order_relaxed)) {
      throw Error(ErrorKind::cancelled, "relighting was cancelled");
    }
  }

 private:
  void record(const Pass& pass, const PassCounts& counts) {
    uint64_t all_words = 0;
    for (const PackedTile& tile : cache_.tiles()) {
      all_words += words_of(cache_, tile, {0, tile.block_count});
    }
    const double share =
        static_cast<double>(counts.words) / static_cast<double>(std::max<uint64_t>(1, all_words));
    const double records = share * static_cast<double>(cache_.info().record_count);
    stats_.records_shaded += static_cast<uint64_t>(std::llround(records));
    stats_.layers_shaded += static_cast<int>(pass.jobs.size());
    stats_.tiles_missed += counts.tiles_missed;
    stats_.replaced_values += counts.replaced;
    replaced_values.add(counts.replaced);
  }

  /// Fills scratch.lights and scratch.places; a layer whose light misses the tile is dark there.
  void find_lights(const Pass& pass, size_t t, TileScratch& scratch) {
    scratch.lights.clear();
    scratch.places.clear();
    for (const Job& job : pass.jobs) {
      const bool lit =
          !may_miss(job.kernel_light) || can_reach(job.kernel_light, state_.tile_bounds[t]);
      scratch.places.push_back(scratch.lights.size());
      if (lit) scratch.lights.push_back(job.kernel_light);
      state_.layers[job.light].set_lit(t, lit);
    }
  }

  void shade_tile(const Pass& pass, size_t t, TileScratch& scratch, PassCounts& counts) {
    if (pass.jobs.empty()) return;
    const PackedTile& tile = cache_.tiles()[t];
    const BlockRange range{cache_.block_count(tile, pass.jobs[0].from),
                           cache_.block_count(tile, share_)};
    find_lights(pass, t, scratch);
    counts.tiles_missed += pass.jobs.size() - scratch.lights.size();
    if (scratch.lights.empty()) return;
    counts.words += scratch.lights.size() * words_of(cache_, tile, range);
    shader_.shade(tile, scratch.lights, pass.shadows, scratch, range);
    for (size_t j = 0; j < pass.jobs.size(); ++j) {
      Layer& layer = state_.layers[pass.jobs[j].light];
      if (!layer.is_lit(t)) continue;
      float* const sums = scratch.light_sums(scratch.places[j]);
      float* const stored = layer.tile(state_.layout, t);
      const size_t first = size_t{block_floats} * range.first;
      std::copy_n(stored, first, sums);
      counts.replaced += shader_.kernels().make_finite(range.end - range.first, sums + first);
      shader_.kernels().stream_layer(sums + first, range.end - range.first, stored + first);
    }
  }

  RelightState& state_;
  const RelightCache& cache_;
  const TileShader& shader_;
  PixelShare share_;
  const std::atomic<bool>* cancelled_;
  RelightStats& stats_;
};

bool same_weight(const Light& a, const Light& b) {
  return a.weight() == b.weight();
}

/// Brings state.lights up to date and finds the lights whose layers do not hold what is asked for.
/// Layers of lights that moved hold nothing from then on, so that an exception on the way leaves no
/// layer of another light. A
/// muted light is not shaded: its layer waits until it is wanted. `touched`: the lights that
/// changed in any way.
std::vector<Job> take_changed(RelightState& state, std::span<const Light> lights, PixelShare share,
                              std::vector<size_t>& touched) {
  const size_t known = std::min(state.lights.size(), lights.size());
  state.lights.resize(known);
  state.lights.resize(lights.size());
  state.layers.resize(lights.size());
  std::vector<Job> jobs;
  for (size_t i = 0; i < lights.size(); ++i) {
    Layer& layer = state.layers[i];
    const bool same = i < known && same_layer(state.lights[i], lights[i]);
    if (!same) layer.share = PixelShare::none;
    const bool is_current = layer.share >= share || lights[i].mute;
    if (!same || !is_current || !same_weight(state.lights[i], lights[i])) touched.push_back(i);
    state.lights[i] = lights[i];
    if (is_current) continue;
    if (!layer.is_allocated()) layer.allocate(state.layout);
    jobs.push_back(
        {i, make_kernel_light(lights[i], state.cache->info().bounds.radius()), layer.share});
  }
  return jobs;
}

/// A pass for each light that asks `shadows`, which is made ready for one light at a time, then one
/// for all others.
std::vector<Pass> make_passes(const RelightState& state, std::span<const Job> jobs,
                              VisibilitySource* shadows) {
  std::vector<Pass> passes;
  std::vector<Job> unshadowed;
  for (const Job& job : jobs) {
    if (shadows != nullptr && state.lights[job.light].casts_shadow) {
      passes.push_back({{job}, shadows});
    } else {
      unshadowed.push_back(job);
    }
  }
  std::stable_sort(unshadowed.begin(), unshadowed.end(), [](const Job& a, const Job& b) {
    return std::pair(a.from, a.kernel_light.kind) < std::pair(b.from, b.kernel_light.kind);
  });
  for (size_t i = 0; i < unshadowed.size(); ++i) {
    if (i == 0 || unshadowed[i].from != unshadowed[i - 1].from) passes.push_back({});
    passes.back().jobs.push_back(unshadowed[i]);
  }
  return passes;
}

/// True when all pixels of a layer are known once `last` is done.
bool becomes_full(const RelightState& state, const Pass& last, size_t light, PixelShare share) {
  const bool is_shaded = std::any_of(last.jobs.begin(), last.jobs.end(),
                                     [light](const Job& job) { return job.light == light; });
  return (is_shaded ? share : state.layers[light].share) == PixelShare::all;
}

LayerTerm make_term(const RelightState& state, const Pass& last, size_t light) {
  LayerTerm term{&state.layers[light], state.lights[light].weight()};
  for (size_t j = 0; j < last.jobs.size(); ++j) {
    if (last.jobs[j].light == light) term.shaded = static_cast<int>(j);
  }
  return term;
}

/// Whether the sum of all lights but one should be kept, and of which. `kept`: of which it was.
std::optional<size_t> choose_dragged(const RelightState& state, std::span<const size_t> touched,
                                     std::optional<size_t> kept) {
  const bool holds = kept && std::all_of(touched.begin(), touched.end(),
                                         [&](size_t light) { return light == kept; });
  if (holds) return kept;
  if (touched.size() != 1) return {};
  size_t others = 0;
  for (size_t i = 0; i < state.lights.size(); ++i) {
    if (i == touched[0] || state.lights[i].weight() == vec3(0)) continue;
    if (state.layers[i].share != PixelShare::all) return {};
    ++others;
  }
  return others >= 2 ? std::optional(touched[0]) : std::nullopt;
}

/// What the frame is the sum of after the last pass.
LayerTerms make_terms(RelightState& state, const Pass& last, PixelShare share,
                      std::optional<size_t> dragged, bool is_kept) {
  LayerTerms terms;
  if (is_kept) {
    terms.full.push_back({&state.others, vec3(1)});
  } else if (dragged) {
    if (!state.others.is_allocated()) state.others.allocate(state.layout);
    terms.keep = &state.others;
  }
  for (size_t i = 0; i < state.lights.size(); ++i) {
    if (state.lights[i].weight() == vec3(0)) continue;
    if (is_kept && i != dragged) continue;
    const LayerTerm term = make_term(state, last, i);
    if (!becomes_full(state, last, i, share)) {
      terms.coarse.push_back(term);
      const PixelShare known = term.shaded >= 0 ? share : state.layers[i].share;
      terms.share = std::min(terms.share, known);
    } else if (dragged && !is_kept && i != dragged) {
      terms.kept.push_back(term);
    } else {
      terms.full.push_back(term);
    }
  }
  return terms;
}

}  // namespace

RelightState make_relight_state(const RelightCache& cache) {
  return {&cache, {}, emission_image(cache), LayerLayout(cache), {}, {}, {}, {}};
}

RelightStats relight(RelightState& state, std::span<const Light> lights, VisibilitySource* shadows,
                     const RelightParams& params) {
  CHECK(params.pixels != PixelShare::none);
  for (size_t i = 0; i < lights.size(); ++i) {
    validate_light(lights[i], fmt::format("lights/{} ({})", i, lights[i].name));
  }
  const TileShader shader(*state.cache, params.instruction_set);
  const bool same_count = state.lights.size() == lights.size();
  const auto kept = same_count ? state.others_of : std::nullopt;
  state.others_of.reset();
  std::vector<size_t> touched;
  const std::vector<Job> jobs = take_changed(state, lights, params.pixels, touched);
  const bool any_may_miss = std::any_of(jobs.begin(), jobs.end(),
                                        [](const Job& job) { return may_miss(job.kernel_light); });
  if (any_may_miss && state.tile_bounds.empty()) state.tile_bounds = tile_bounds(*state.cache);
  std::vector<Pass> passes = make_passes(state, jobs, shadows);
  if (passes.empty()) passes.push_back({});

  const auto dragged = params.dragging ? choose_dragged(state, touched, kept) : std::nullopt;
  RelightStats stats;
  LayerShader layers(state, shader, params, stats);
  for (Pass& pass : passes) {
    layers.check_cancelled();
    const Timer prepare_timer;
    if (pass.shadows != nullptr) {
      pass.shadows->prepare_share(state.lights[pass.jobs[0].light], params.pixels);
      // What it told a share of the pixels may not be what it tells all of them.
      if (!pass.shadows->all_visibility().empty()) pass.jobs[0].from = PixelShare::none;
    }
    stats.prepare_ms += prepare_timer.ms();
    const Timer timer;
    if (&pass != &passes.back()) {
      layers.run(pass, nullptr);
    } else {
      LayerTerms terms =
          make_terms(state, pass, params.pixels, dragged, dragged && dragged == kept);
      const Combiner combiner(*state.cache, state.layout, shader.kernels(), std::move(terms),
                              state.frame);
      layers.run(pass, &combiner);
    }
    (pass.jobs.empty() ? stats.combine_ms : stats.shade_ms) += timer.ms();
  }
  state.others_of = dragged;
  return stats;
}

void invalidate(RelightState& state) {
  state.others_of.reset();
  for (Layer& layer : state.layers) layer.share = PixelShare::none;
}

void invalidate(RelightState& state, size_t i) {
  if (i >= state.layers.size()) return;
  state.layers[i].share = PixelShare::none;
  if (state.others_of != i) state.others_of.reset();
}

namespace {

Image make_layer_image(const RelightState& state, size_t i, vec3 weight) {
  CHECK_MSG(i < state.layers.size(), "layer {} of {}", i, state.layers.size());
  const RelightCache& cache = *state.cache;
  Image image(state.frame.width, state.frame.height);
  const Layer& layer = state.layers[i];
  if (layer.share == PixelShare::none) return image;
  const BlockKernels kernels = block_kernels(choose_instruction_set(InstructionSet::automatic));
  const BlockPixels pixels(cache, kernels);
  for (size_t t = 0; t < cache.tiles().size(); ++t) {
    if (!layer.is_lit(t)) continue;
    const PackedTile& tile = cache.tiles()[t];
    const int known = cache.block_count(tile, layer.share);
    alignas(64) float sums[tile_floats] = {};
    kernels.add_layer(layer.tile(state.layout, t), &weight.x, known, sums);
    replaced_values.add(kernels.make_finite(known, sums));
    pixels.write(tile, known, sums, image);
  }
  return image;
}

}  // namespace

Image layer_image(const RelightState& state, size_t i) {
  return make_layer_image(state, i, vec3(1));
}

Image weighted_layer(const RelightState& state, size_t i) {
  CHECK_MSG(i < state.lights.size(), "light {} of {}", i, state.lights.size());
  return make_layer_image(state, i, state.lights[i].weight());
}

size_t layer_bytes(const RelightState& state) {
  size_t bytes = state.others.size_bytes();
  for (const Layer& layer : state.layers) bytes += layer.size_bytes();
  return bytes;
}

}  // namespace relume
