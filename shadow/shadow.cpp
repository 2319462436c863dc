#include "shadow/shadow.h"

#include "core/base/timer.h"
#include "shadow/automatic.h"
#include "shadow/coverage.h"
#include "shadow/members.h"
#include "shadow/receiver_boxes.h"
#include "shadow/traced.h"

namespace relume {
namespace {

std::unique_ptr<VisibilitySource> make_automatic(const Tracer& tracer, const RelightCache& cache,
                                                 const ShadowParams& params) {
  const ShadowContent content{!SceneStrips(tracer.scene()).empty(), cache.info().has_members};
  const auto make = [&tracer, &cache, params](ShadowMethod method) {
    return make_shadow(method, tracer, cache, params);
  };
  return std::make_unique<AutomaticVisibility>(content, make,
                                               [timer = Timer()] { return timer.ms(); });
}

}  // namespace

std::unique_ptr<VisibilitySource> make_shadow(ShadowMethod method, const Tracer& tracer,
                                              const RelightCache& cache,
                                              const ShadowParams& params) {
  switch (method) {
    case ShadowMethod::none:
      return nullptr;
    case ShadowMethod::ray:
      return std::make_unique<TracedVisibility>(tracer);
    case ShadowMethod::members:
      return std::make_unique<MemberVisibility>(tracer, cache, params.member_rays);
    case ShadowMethod::coverage:
      return std::make_unique<CoverageVisibility>(tracer, cache);
    case ShadowMethod::opacity:
      return std::make_unique<OpacityVisibility>(
          tracer.scene(), receiver_boxes(ViewReceivers(cache)), params.opacity);
    case ShadowMethod::volume:
      return std::make_unique<VolumeVisibility>(
          tracer.scene(), receiver_boxes(ViewReceivers(cache)), params.volume);
    case ShadowMethod::automatic:
      return make_automatic(tracer, cache, params);
  }
  return nullptr;
}

}  // namespace relume
