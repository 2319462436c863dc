#include "shadow/shadow.h"

#include "shadow/traced.h"

namespace relume {

std::unique_ptr<VisibilitySource> make_shadow(ShadowMethod method, const Tracer& tracer) {
  switch (method) {
    case ShadowMethod::none:
      return nullptr;
    case ShadowMethod::ray:
      return std::make_unique<TracedVisibility>(tracer);
  }
  return nullptr;
}

}  // namespace relume
