#include "viewer/session/frame_source.h"

#include "core/base/error.h"
#include "shadow/automatic.h"
#include "viewer/session/frame_budget.h"

namespace relume {
namespace {

/// Of a light at rest, when nothing is said.
constexpr double unlimited_ms = 1e9;

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
    if (automatic_ != nullptr) set_level(request);
    frame.stats =
        relight(state_, request.lights, shadows_.get(),
                {.pixels = request.pixels, .dragging = request.dragging, .cancelled = &cancelled});
    frame.image = state_.frame;
    frame.work = make_frame_work(request, frame.stats);
    frame.shadows_used.clear();
    if (automatic_ == nullptr) return;
    if (!request.dragging) std::fill(is_preview_.begin(), is_preview_.end(), false);
    if (frame.stats.layers_shaded > 0) automatic_->end_move();
    frame.shadows_used = automatic_->choice().reason;
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

  /// Lights that were shaded while they were dragged are shaded anew when they rest.
  void set_level(const RelightRequest& request) {
    automatic_->set_goal(request.dragging ? ShadowLevel::drag : ShadowLevel::rest,
                         request.frame_ms > 0 ? double{request.frame_ms} : unlimited_ms);
    is_preview_.resize(request.lights.size(), false);
    for (size_t i = 0; i < request.lights.size(); ++i) {
      if (request.dragging) {
        const bool is_known =
            i < state_.lights.size() && same_layer(state_.lights[i], request.lights[i]);
        is_preview_[i] = is_preview_[i] || !is_known;
      } else if (is_preview_[i]) {
        invalidate(state_, i);
      }
    }
  }

  void use_shadows(ShadowMethod method) {
    if (method == method_) return;
    if (method != ShadowMethod::none && tracer_ == nullptr) {
      throw input_error("shadows", "the scene of this cache is not loaded",
                        "set shadows to none, or open the scene instead of the cache");
    }
    shadows_ = method == ShadowMethod::none ? nullptr : make_shadow(method, *tracer_, cache_);
    automatic_ = dynamic_cast<AutomaticVisibility*>(shadows_.get());
    is_preview_.clear();
    method_ = method;
    invalidate(state_);
  }

  RelightCache cache_;
  const Tracer* tracer_;
  std::optional<ShadowMethod> fixed_method_;
  ShadowMethod method_ = ShadowMethod::none;
  std::unique_ptr<VisibilitySource> shadows_;
  AutomaticVisibility* automatic_ = nullptr;  ///< shadows_, where it is one
  std::vector<bool> is_preview_;  ///< per light: its layer was shaded at the level of a drag
  RelightState state_;
};

}  // namespace

std::unique_ptr<FrameSource> make_cache_source(RelightCache cache, const Tracer* tracer,
                                               std::optional<ShadowMethod> shadows) {
  return std::make_unique<CacheSource>(std::move(cache), tracer, shadows);
}

}  // namespace relume
