#pragma once

#include <memory>

#include "shadow/depth_map.h"
#include "shadow/lookup_chunk.h"
#include "shadow/traced.h"

namespace relume {

/// How a lookup kernel sees a map.
DepthLookup make_depth_lookup(const DepthMap& map, float bias_texels);

/// Shadows of a scene's solids, by rays against them alone. A small map of what the light sees of
/// them saves most rays: where it shows a solid before a receiver over three texels each way the
/// receiver is dark, where it shows none it is lit, and only the rest is traced. Solids and gaps
/// narrower than a texel of that map are missed.
class SolidShadow {
 public:
  /// `boxes`: where receivers are; empty: the scene's bounds.
  SolidShadow(const SceneStrips& strips, std::vector<Bounds> boxes);

  void prepare(const Light& light);

  /// Multiplies each lit lane's visibility, not 0, by whether solids let the light through.
  void apply(LookupChunk& chunk) const;

  /// Which of `points` (position, anything) lie so deep in a solid's shadow that their map says so
  /// without rays: 1, else 0. All threads.
  void mark_hidden(std::span<const vec4> points, std::vector<uint8_t>& hidden) const;

  bool empty() const { return tracer_ == nullptr; }
  uint64_t memory_bytes() const;

 private:
  LookupKernels kernels_;
  std::vector<Bounds> boxes_;
  std::unique_ptr<const Scene> scene_;
  std::unique_ptr<const Tracer> tracer_;
  std::unique_ptr<TracedVisibility> rays_;
  std::unique_ptr<SceneStrips> pieces_;  ///< the solids' triangles
  std::vector<DepthMap> maps_;
  std::vector<DepthLookup> lookups_;
};

}  // namespace relume
