#include "viewer/session/frame_source.h"

#include "core/base/error.h"
#include "viewer/session/frame_budget.h"

namespace relume {
namespace {

class CacheSource final : public FrameSource {
 public:
  CacheSource(RelightCache cache, const Tracer* tracer, std::optional<ShadowMethod> shadows)
      : cache_(std::move(cache)),
        tracer_(tracer),
        fixed_method_(shadows),
        state_(make_relight_state(cache_)) {}

  void render(const RelightRequest& request, const std::atomic<bool>& cancelled,
              RelitFrame& frame) override {
    use_shadows(fixed_method_.value_or(request.shadows));
    frame.stats =
        relight(state_, request.lights, shadows_.get(),
                {.pixels = request.pixels, .dragging = request.dragging, .cancelled = &cancelled});
    frame.image = state_.frame;
    frame.work = make_frame_work(request, frame.stats);
  }

  const RelightCache* cache() const override { return &cache_; }

 private:
  FrameWork make_frame_work(const RelightRequest& request, const RelightStats& stats) const {
    const auto lights = static_cast<int>(request.lights.size());
    FrameWork work = relume::make_frame_work(cache_, stats.layers_shaded,
                                             state_.others_of ? std::min(2, lights) : lights);
    work.records *= share_cost(request.pixels);
    return work;
  }

  void use_shadows(ShadowMethod method) {
    if (method == method_) return;
    if (method != ShadowMethod::none && tracer_ == nullptr) {
      throw input_error("shadows", "the scene of this cache is not loaded",
                        "set shadows to none, or open the scene instead of the cache");
    }
    shadows_ = method == ShadowMethod::none ? nullptr : make_shadow(method, *tracer_, cache_);
    method_ = method;
    invalidate(state_);
  }

  RelightCache cache_;
  const Tracer* tracer_;
  std::optional<ShadowMethod> fixed_method_;
  ShadowMethod method_ = ShadowMethod::none;
  std::unique_ptr<VisibilitySource> shadows_;
  RelightState state_;
};

}  // namespace

std::unique_ptr<FrameSource> make_cache_source(RelightCache cache, const Tracer* tracer,
                                               std::optional<ShadowMethod> shadows) {
  return std::make_unique<CacheSource>(std::move(cache), tracer, shadows);
}

}  // namespace relume
