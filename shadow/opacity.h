#pragma once

#include <memory>

#include "core/relight/visibility.h"
#include "core/trace/tracer.h"
#include "shadow/depth_map.h"
#include "shadow/traced.h"

namespace relume {

struct OpacityParams {
  uint64_t max_texels = 4u << 20;
};

class OpacityVisibility final : public VisibilitySource {
 public:
  OpacityVisibility(const Scene& scene, std::vector<Bounds> receivers,
                    const OpacityParams& params = {});

  void prepare(const Light& light) override;
  void visibility(const Receivers& receivers, float* visibility) const override;

  size_t memory_bytes() const;

 private:
  float seen_fraction(vec3 position, float bias) const;

  const Scene& scene_;
  OpacityParams params_;
  ThinGeometry thin_;
  StrandSet strands_;
  std::vector<Bounds> receiver_boxes_;
  std::vector<DepthMap> maps_;
  std::vector<LightView> views_;
  std::unique_ptr<const Scene> solid_scene_;
  std::unique_ptr<const Tracer> solid_tracer_;
  std::unique_ptr<TracedVisibility> solids_;
  Light light_;
  vec3 to_light_{0, 1, 0};  ///< unit, against the light's direction
  float cos_outer_ = 0;     ///< spot
};

}  // namespace relume
