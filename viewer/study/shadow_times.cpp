#include "viewer/study/shadow_times.h"

#include <limits>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/timer.h"
#include "core/relight/pixel_visibility.h"
#include "core/relight/receivers.h"
#include "core/samples/relight_cache.h"
#include "shadow/shadow.h"

namespace relume {
namespace {

/// Asks for the records of the pixels that coarse frames shade.
void query_coarse(const RelightCache& cache, const VisibilitySource& source) {
  const BlockDecoder decoder(cache, InstructionSet::automatic);
  const auto tiles = cache.tiles();
  parallel_for(tiles.size(), 1, [&](size_t begin, size_t end) {
    std::vector<float> scratch;
    std::vector<float> visibility;
    for (size_t t = begin; t < end; ++t) {
      size_t first = tiles[t].first_slot * block_lanes;
      const int blocks = cache.block_count(tiles[t], PixelShare::quarter);
      for (int b = 0; b < blocks; ++b) {
        const PackedBlock block = cache.block(tiles[t], b);
        query_block(cache.info(), block, decoder.floats(block, scratch), first, source, visibility);
        first += visibility.size();
      }
    }
  });
}

}  // namespace

ShadowTimes time_moves(const Tracer& tracer, const RelightCache& cache, const StudyLight& light,
                       ShadowMethod shadow, int repeats) {
  const auto source = make_shadow(shadow, tracer, cache);
  CHECK(source != nullptr);
  ShadowTimes times;
  times.ms_move = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repeats; ++i) {
    const Timer timer;
    source->prepare(light.path[static_cast<size_t>(i) % light.path.size()]);
    const double prepared_ms = timer.ms();
    query_cache(cache, *source);
    const double ms = timer.ms();
    if (ms >= times.ms_move) continue;
    times.ms_move = ms;
    times.ms_prepare = prepared_ms;
  }
  // A coarse frame asks for a quarter of the pixels, unless prepare() answers for all.
  times.ms_coarse = times.ms_move;
  if (source->all_visibility().empty()) {
    double look_up_ms = std::numeric_limits<double>::infinity();
    for (int i = 0; i < repeats; ++i) {
      const Timer timer;
      query_coarse(cache, *source);
      look_up_ms = std::min(look_up_ms, timer.ms());
    }
    times.ms_coarse = times.ms_prepare + look_up_ms;
  }
  times.records_per_s = static_cast<double>(cache.info().record_count) / (times.ms_move * 1e-3);
  return times;
}

}  // namespace relume
