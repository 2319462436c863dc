#pragma once

#include <memory>
#include <optional>

#include "shadow/shadow_rays.h"
#include "shadow/thin_projection.h"

namespace relume {

/// What the last CoverageVisibility::prepare() did.
struct CoverageStats {
  double build_ms = 0;      ///< projecting, sorting and boxing receivers
  double project_ms = 0;    ///< thin geometry into the light's picture
  double shade_ms = 0;      ///< overlaps
  double trace_ms = 0;      ///< rays
  uint64_t receivers = 0;   ///< that the light may light
  uint64_t primitives = 0;  ///< that reach a receiver's neighbourhood
  uint64_t tests = 0;       ///< receivers x primitives looked at
  uint64_t rays = 0;
};

/// Receiver-binned analytic coverage: the part of each receiver's footprint that thin geometry
/// leaves to the light, computed by a rasteriser from the light that draws onto the receivers
/// themselves; solids by one ray a receiver. See docs/shadows.md.
class CoverageVisibility final : public VisibilitySource {
 public:
  /// Keeps references to all.
  CoverageVisibility(const Tracer& tracer, const RelightCache& cache,
                     InstructionSet set = InstructionSet::automatic);

  /// Computes all visibilities, in parallel; bit-equal for any thread count.
  void prepare(const Light& light) override { prepare_share(light, PixelShare::all); }
  void prepare_share(const Light& light, PixelShare share) override;
  void visibility(const Receivers& receivers, float* visibility) const override;
  std::span<const float> all_visibility() const override { return visibility_; }
  uint64_t memory_bytes() const override;

  const CoverageStats& stats() const { return stats_; }
  /// Whether solids are asked by rays; else there are none, or so few that they are drawn.
  bool traces_solids() const { return solids_.has_value(); }

 private:
  void rasterise(const LightViews& lights);
  void rasterise_part(const LightViews& lights, std::span<const ProjectionWork> work);
  void shade_leaves();
  void collect(PixelShare share);
  void collect_receivers(std::span<const ReceiverLink> links);
  void trace(const Light& light, PixelShare share);

  ViewReceivers view_;
  ThinGeometry geometry_;
  std::optional<Tracer> solids_;  ///< nothing when all is thin
  ShadowRays all_rays_;
  CoverageKernels kernels_;
  LearnedReceivers receivers_;
  ReceiverTree tree_;
  std::vector<ReceiverState> states_;
  std::vector<KeyedIndex> scratch_;
  std::vector<ProjectedGeometry> groups_;
  std::vector<float> seen_;  ///< per spot
  std::vector<float> visibility_;
  CoverageStats stats_;
};

}  // namespace relume
