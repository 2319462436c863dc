#include "shadow/opacity.h"

#include <cstdlib>

#include "core/base/parallel.h"
#include "core/base/timer.h"

namespace relume {
namespace {
float env(const char* name, float value) {
  const char* text = std::getenv(name);
  return text ? static_cast<float>(std::atof(text)) : value;
}
const float bias_texels = env("OBIAS", 2.0f);
const int kernel = static_cast<int>(env("OKERNEL", 2));
}  // namespace

OpacityVisibility::OpacityVisibility(const Scene& scene, std::vector<Bounds> receivers,
                                     const OpacityParams& params)
    : scene_(scene), params_(params), thin_(scene), receiver_boxes_(std::move(receivers)) {
  params_.max_texels = static_cast<uint64_t>(env("OTEXELS", 4) * (1 << 20));
  if (receiver_boxes_.empty()) receiver_boxes_.push_back(thin_.bounds());
  strands_ = thin_.strands();
  solid_scene_ = std::make_unique<const Scene>(thin_.solids());
  if (!solid_scene_->instances.empty()) {
    solid_tracer_ = std::make_unique<const Tracer>(*solid_scene_);
    solids_ = std::make_unique<TracedVisibility>(*solid_tracer_);
  }
}

size_t OpacityVisibility::memory_bytes() const {
  size_t bytes = 0;
  for (const DepthMap& map : maps_) bytes += map.memory_bytes();
  return bytes;
}

void OpacityVisibility::prepare(const Light& light) {
  light_ = light;
  to_light_ = -normalize_or(light.direction, vec3(0, -1, 0));
  cos_outer_ = std::cos(radians_from_degrees(light.outer_angle_deg));
  if (solids_) solids_->prepare(light);
  const Timer timer;
  views_ = make_light_views(light, receiver_boxes_, thin_.bounds(), params_.max_texels);
  maps_.resize(views_.size());
  for (size_t i = 0; i < views_.size(); ++i) maps_[i].reset(views_[i]);
  if (env("OVERB", 0) > 0)
    for (auto& v : views_)
      fprintf(stderr, "view %d %d persp %d scale %g\n", v.width, v.height, v.perspective, v.scale);
  for (DepthMap& map : maps_) {
    const Timer t2;
    map.draw_strands(strands_);
    if (env("OVERB", 0) > 0) fprintf(stderr, "strands %.1f ms\n", t2.ms());
    parallel_for(thin_.instance_count(), 8, [&](size_t b, size_t e) {
      for (size_t i = b; i < e; ++i) {
        if (!thin_.has_triangles(i)) continue;
        thin_.visit(i, [&](const ThinPiece& p) {
          if (!p.is_strand()) map.draw(p);
        });
      }
    });
  }
  if (env("OVERB", 0) > 0) fprintf(stderr, "prepare %.1f ms\n", timer.ms());
}

float OpacityVisibility::seen_fraction(vec3 position, float bias) const {
  const int index = find_view(views_, position);
  if (index < 0) return 1;
  const DepthMap& map = maps_[index];
  const LightView& view = views_[index];
  const vec3 p = view.to_light(position);
  if (view.perspective && p.z < view.near) return 1;
  const LightView::Projection at = view.project(p);
  const float limit = view.nearness_before(p.z, bias + bias_texels * view.texel_size(p.z));
  const float width = static_cast<float>(kernel);
  const float u = at.u - 0.5f * width;
  const float v = at.v - 0.5f * width;
  const int x0 = static_cast<int>(std::floor(u));
  const int y0 = static_cast<int>(std::floor(v));
  if (x0 < 0 || y0 < 0 || x0 + kernel >= view.width || y0 + kernel >= view.height) return 1;
  const float fu = u - static_cast<float>(x0);
  const float fv = v - static_cast<float>(y0);
  float sum = 0;
  for (int j = 0; j <= kernel; ++j) {
    const float wv = j == 0 ? 1 - fv : j == kernel ? fv : 1;
    const float* row = map.texels() + static_cast<size_t>(y0 + j) * view.width + x0;
    for (int i = 0; i <= kernel; ++i) {
      const float wu = i == 0 ? 1 - fu : i == kernel ? fu : 1;
      if (row[i] > limit) sum += wu * wv;
    }
  }
  return std::clamp(1 - sum / (width * width), 0.0f, 1.0f);
}

void OpacityVisibility::visibility(const Receivers& receivers, float* visibility) const {
  constexpr int most = 64;
  const bool on_surface = receivers.normal[0] != nullptr;
  for (int first = 0; first < receivers.count; first += most) {
    const int count = std::min(most, receivers.count - first);
    float weight[most];
    float pass[most];
    for (int i = 0; i < count; ++i) {
      const int r = first + i;
      pass[i] = 1;
      weight[i] = 0;
      if (!(receivers.weight[r] > 0)) continue;
      const vec3 p(receivers.position[0][r], receivers.position[1][r], receivers.position[2][r]);
      const vec3 wi = light_.type == LightType::directional
                          ? to_light_
                          : normalize_or(light_.position - p, to_light_);
      if (light_.type == LightType::spot && glm::dot(wi, to_light_) < cos_outer_) continue;
      if (on_surface) {
        const vec3 n(receivers.normal[0][r], receivers.normal[1][r], receivers.normal[2][r]);
        if (!receivers.lit_from_behind && glm::dot(n, wi) <= 0) continue;
      }
      pass[i] = thin_.empty() ? 1.0f : seen_fraction(p, receivers.bias[r]);
      weight[i] = pass[i] > 0 ? 1.0f : 0.0f;
    }
    float solid[most];
    std::fill(solid, solid + count, 1.0f);
    if (solids_) {
      Receivers part = receivers;
      part.count = count;
      part.weight = weight;
      for (int axis = 0; axis < 3; ++axis) {
        part.position[axis] += first;
        if (on_surface) part.normal[axis] += first;
      }
      part.bias += first;
      solids_->visibility(part, solid);
    }
    for (int i = 0; i < count; ++i) {
      visibility[first + i] = weight[i] > 0 ? pass[i] * solid[i] : pass[i];
    }
  }
}

}  // namespace relume
