#include "core/relight/combine.h"

#include "core/relight/emission.h"
#include "core/relight/fill_pixels.h"

namespace relume {

Combiner::Combiner(const RelightCache& cache, const LayerLayout& layout,
                   const BlockKernels& kernels, LayerTerms terms, Image& frame)
    : cache_(cache),
      layout_(layout),
      kernels_(kernels),
      pixels_(cache, kernels),
      terms_(std::move(terms)),
      frame_(frame) {}

/// True when any of the lights reaches the tile.
bool Combiner::add(const std::vector<LayerTerm>& terms, size_t t, int blocks, TileScratch& scratch,
                   float* sums) const {
  bool lit = false;
  for (const LayerTerm& term : terms) {
    if (!term.layer->is_lit(t)) continue;
    const float* const layer = term.shaded >= 0 ? scratch.light_sums(scratch.places[term.shaded])
                                                : term.layer->tile(layout_, t);
    kernels_.add_layer(layer, &term.weight.x, blocks, sums);
    lit = true;
  }
  return lit;
}

void Combiner::prefetch(size_t t) const {
  const PackedTile& tile = cache_.tiles()[t];
  for (int y = tile.y0; y < tile.y0 + tile.height; ++y) {
    const float* const row = frame_.at(tile.x0, y);
    for (int i = 0; i < 3 * tile.width; i += 16) __builtin_prefetch(row + i, 1);
  }
  // Sums of many layers stream by themselves.
  if (!terms_.kept.empty() || terms_.full.size() > 2) return;
  const int floats = tile.block_count * block_floats;
  for (const LayerTerm& term : terms_.full) {
    if (term.shaded >= 0 || !term.layer->is_lit(t)) continue;
    const float* const layer = term.layer->tile(layout_, t);
    for (int i = 0; i < floats; i += 16) __builtin_prefetch(layer + i);
  }
}

int Combiner::combine(size_t t, TileScratch& scratch) const {
  const PackedTile& tile = cache_.tiles()[t];
  const int blocks = tile.block_count;
  alignas(64) float sums[tile_floats];
  std::fill_n(sums, blocks * block_floats, 0.0f);
  const bool kept = add(terms_.kept, t, blocks, scratch, sums);
  if (terms_.keep != nullptr) {
    terms_.keep->set_lit(t, kept);
    if (kept) std::copy_n(sums, blocks * block_floats, terms_.keep->tile(layout_, t));
  }
  add(terms_.full, t, blocks, scratch, sums);
  if (!terms_.coarse.empty()) {
    alignas(64) float coarse[tile_floats] = {};
    const int shaded = cache_.block_count(tile, terms_.share);
    if (add(terms_.coarse, t, shaded, scratch, coarse)) {
      const float one[3] = {1, 1, 1};
      fill_pixels(cache_, tile, shaded, coarse);
      kernels_.add_layer(coarse, one, blocks, sums);
    }
  }
  const int replaced = kernels_.make_finite(blocks, sums);
  pixels_.write(tile, blocks, sums, frame_);
  if (tile.emission != nullptr) add_emission(cache_, tile, frame_);
  return replaced;
}

}  // namespace relume
