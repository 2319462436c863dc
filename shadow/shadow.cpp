#include "shadow/shadow.h"

#include "shadow/coverage.h"
#include "shadow/members.h"
#include "shadow/receiver_boxes.h"
#include "shadow/traced.h"

namespace relume {

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
  }
  return nullptr;
}

}  // namespace relume
