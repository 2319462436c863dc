#include "shadow/solid_shadow.h"

#include "core/base/parallel.h"

namespace relume {
namespace {

constexpr uint64_t map_texels = uint64_t{1} << 18;

/// A receiver this many texels behind what a map shows is dark.
constexpr float behind_texels = 4;

/// Scenes with more solid triangles than this are only traced: drawing them would cost more.
constexpr uint64_t most_drawn = 1'000'000;

}  // namespace

DepthLookup make_depth_lookup(const DepthMap& map, float bias_texels) {
  const LightPlane& view = map.view();
  DepthLookup lookup{};
  lookup.texels = map.texels();
  lookup.width = view.width;
  lookup.height = view.height;
  const vec3 axes[3] = {view.x, view.y, view.z};
  for (int i = 0; i < 3; ++i) {
    lookup.origin[i] = view.origin[i];
    for (int axis = 0; axis < 3; ++axis) lookup.axes[axis][i] = axes[axis][i];
  }
  lookup.perspective = view.perspective;
  lookup.scale = view.scale;
  lookup.offset_u = view.offset_u;
  lookup.offset_v = view.offset_v;
  lookup.far = view.far;
  lookup.near = view.near;
  lookup.bias_texels = bias_texels;
  return lookup;
}

SolidShadow::SolidShadow(const SceneStrips& strips, std::vector<Bounds> boxes)
    : kernels_(best_lookup_kernels()), boxes_(std::move(boxes)) {
  scene_ = std::make_unique<const Scene>(strips.solids());
  if (scene_->instances.empty()) return;
  tracer_ = std::make_unique<const Tracer>(*scene_);
  rays_ = std::make_unique<TracedVisibility>(*tracer_);
  if (boxes_.empty()) boxes_.push_back(tracer_->bounds());
  if (count_scene(*scene_).instanced_triangles <= most_drawn) {
    pieces_ = std::make_unique<SceneStrips>(*scene_, true);
  }
}

uint64_t SolidShadow::memory_bytes() const {
  uint64_t bytes = tracer_ != nullptr ? tracer_->stats().memory_bytes : 0;
  for (const DepthMap& map : maps_) bytes += map.memory_bytes();
  return bytes;
}

void SolidShadow::prepare(const Light& light) {
  if (empty()) return;
  rays_->prepare(light);
  lookups_.clear();
  if (pieces_ == nullptr) return;
  const auto views = fit_light_planes(light, boxes_, pieces_->bounds(), map_texels);
  maps_.resize(views.size());
  for (size_t i = 0; i < views.size(); ++i) {
    maps_[i].reset(views[i]);
    maps_[i].draw_triangles(*pieces_);
    lookups_.push_back(make_depth_lookup(maps_[i], behind_texels));
  }
}

void SolidShadow::mark_hidden(std::span<const vec4> points, std::vector<uint8_t>& hidden) const {
  hidden.assign(points.size(), 0);
  if (lookups_.empty()) return;
  const size_t groups = (points.size() + lookup_lanes - 1) / lookup_lanes;
  parallel_for(groups, 512, [&](size_t begin, size_t end) {
    float position[3][lookup_lanes];
    const float bias[lookup_lanes] = {};
    for (size_t group = begin; group < end; ++group) {
      const size_t first = group * lookup_lanes;
      for (size_t lane = 0; lane < lookup_lanes; ++lane) {
        const vec4 p = points[std::min(first + lane, points.size() - 1)];
        for (int axis = 0; axis < 3; ++axis) position[axis][lane] = p[axis];
      }
      float state[lookup_lanes];
      std::fill(std::begin(state), std::end(state), 2.0f);
      for (const DepthLookup& lookup : lookups_) {
        kernels_.sort_by_depth(lookup, {{position[0], position[1], position[2]}, bias}, state);
      }
      for (size_t lane = 0; lane < lookup_lanes && first + lane < points.size(); ++lane) {
        hidden[first + lane] = state[lane] == 1 ? 1 : 0;
      }
    }
  });
}

void SolidShadow::apply(LookupChunk& chunk) const {
  if (empty() || !chunk.any_lit) return;
  float state[lookup_lanes];
  std::fill(std::begin(state), std::end(state), 2.0f);
  for (const DepthLookup& lookup : lookups_) {
    kernels_.sort_by_depth(lookup, chunk.receivers(), state);
  }
  float asks[lookup_lanes];
  bool asks_any = false;
  for (int lane = 0; lane < lookup_lanes; ++lane) {
    const bool asked = chunk.lit[lane] > 0 && chunk.passed[lane] > 0 && state[lane] == 2;
    asks[lane] = asked ? 1.0f : 0.0f;
    asks_any = asks_any || asked;
    if (state[lane] == 1) chunk.passed[lane] = 0;
  }
  if (!asks_any) return;
  float seen[lookup_lanes];
  rays_->visibility(chunk.as_receivers(asks), seen);
  for (int lane = 0; lane < lookup_lanes; ++lane) {
    if (asks[lane] > 0) chunk.passed[lane] *= seen[lane];
  }
}

}  // namespace relume
