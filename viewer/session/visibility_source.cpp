#include "viewer/session/visibility_source.h"

#include "core/base/check.h"
#include "core/relight/pixel_visibility.h"

namespace relume {
namespace {

class MapSource final : public FrameSource {
 public:
  MapSource(const RelightCache& cache, const Tracer& tracer) : cache_(cache), tracer_(tracer) {}

  void render(const RelightRequest& request, const std::atomic<bool>&, RelitFrame& frame) override {
    CHECK(!request.lights.empty());
    const ShadowMethod method =
        request.shadows == ShadowMethod::none ? ShadowMethod::ray : request.shadows;
    if (!shadows_ || method != method_) shadows_ = make_shadow(method, tracer_, cache_);
    method_ = method;
    shadows_->prepare(request.lights.front());
    frame.image =
        make_map(cache_.info().width, cache_.info().height, pixel_visibility(cache_, *shadows_));
  }

 private:
  const RelightCache& cache_;
  const Tracer& tracer_;
  ShadowMethod method_ = ShadowMethod::none;
  std::unique_ptr<VisibilitySource> shadows_;
};

}  // namespace

std::unique_ptr<FrameSource> make_visibility_source(const RelightCache& cache,
                                                    const Tracer& tracer) {
  return std::make_unique<MapSource>(cache, tracer);
}

}  // namespace relume
