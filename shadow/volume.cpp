#include "shadow/volume.h"

#include <cstdlib>

#include "core/base/parallel.h"
#include "core/base/timer.h"

namespace relume {
namespace {

float env(const char* name, float value) {
  const char* text = std::getenv(name);
  return text ? static_cast<float>(std::atof(text)) : value;
}
const float gap_cells = env("VGAP", 1.0f);
const int steps_level = static_cast<int>(env("VSTEPS", 8));
const float law = env("VLAW", 2);
const float self = env("VSELF", 0);

constexpr float full = 65535.0f;

int dominant_axis(vec3 w) {
  const vec3 a = glm::abs(w);
  return a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
}

uint16_t to_code(float coverage) {
  return static_cast<uint16_t>(std::clamp(coverage, 0.0f, 1.0f) * full + 0.5f);
}

}  // namespace

VolumeVisibility::VolumeVisibility(const Scene& scene, const VolumeParams& params,
                                   const Bounds& region) {
  const ThinGeometry thin(scene);
  VolumeParams p = params;
  p.max_cells = static_cast<uint64_t>(env("VCELLS", 48) * 1e6f);
  p.max_occupied = static_cast<uint64_t>(env("VOCC", 6) * 1e6f);
  const Timer timer;
  grid_ = make_volume_grid(thin, p, region);
  fprintf(stderr, "grid %d %d %d cell %g occupied %zu thin %llu, %.0f ms\n", grid_.size[0],
          grid_.size[1], grid_.size[2], grid_.cell, grid_.occupied.size(),
          (unsigned long long)thin.count(), timer.ms());
  solid_scene_ = std::make_unique<const Scene>(thin.solids());
  if (!solid_scene_->instances.empty()) {
    solid_tracer_ = std::make_unique<const Tracer>(*solid_scene_);
    solids_ = std::make_unique<TracedVisibility>(*solid_tracer_);
  }
  levels_[0].occupied = grid_.occupied;
  for (int l = 0; l < volume_levels; ++l) {
    Level& level = levels_[l];
    for (int axis = 0; axis < 3; ++axis) level.size[axis] = grid_.size[axis] >> l;
    level.coverage.assign(uint64_t{1} * level.size[0] * level.size[1] * level.size[2], 0);
    const std::vector<uint32_t>& finer = l == 0 ? grid_.occupied : levels_[l - 1].occupied;
    if (l == 0) continue;
    const uint32_t sx = levels_[l - 1].size[0];
    const uint32_t sy = levels_[l - 1].size[1];
    std::vector<bool> marked(level.coverage.size(), false);
    for (const uint32_t cell : finer) {
      const uint32_t x = cell % sx / 2;
      const uint32_t y = cell / sx % sy / 2;
      const uint32_t z = cell / sx / sy / 2;
      marked[(static_cast<size_t>(z) * level.size[1] + y) * level.size[0] + x] = true;
    }
    for (size_t i = 0; i < marked.size(); ++i) {
      if (marked[i]) level.occupied.push_back(static_cast<uint32_t>(i));
    }
  }
}

size_t VolumeVisibility::memory_bytes() const {
  size_t bytes = grid_.memory_bytes();
  for (const Level& level : levels_) {
    bytes += level.occupied.size() * 4 + level.coverage.size() * 2;
  }
  if (solid_tracer_) bytes += solid_tracer_->stats().memory_bytes;
  return bytes;
}

void VolumeVisibility::prepare(const Light& light) {
  light_ = light;
  to_light_ = -normalize_or(light.direction, vec3(0, -1, 0));
  cos_outer_ = std::cos(radians_from_degrees(light.outer_angle_deg));
  if (solids_) solids_->prepare(light);
  fill_finest();
  for (int level = 1; level < volume_levels; ++level) fill_coarser(level);
}

void VolumeVisibility::fill_finest() {
  Level& level = levels_[0];
  const bool far = light_.type == LightType::directional;
  const vec3 light = (light_.position - grid_.origin) / grid_.cell;
  parallel_for(grid_.occupied.size(), 16384, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const uint32_t cell = grid_.occupied[i];
      const uint32_t x = cell % level.size[0];
      const uint32_t y = cell / level.size[0] % level.size[1];
      const uint32_t z = cell / level.size[0] / level.size[1];
      const vec3 w = far ? to_light_ : normalize_or(light - vec3(x, y, z) - 0.5f, vec3(0, 1, 0));
      const std::array<int8_t, 6>& q = grid_.moments[i];
      const float form = q[0] * w.x * w.x + q[1] * w.y * w.y + q[2] * w.z * w.z +
                         2 * (q[3] * w.x * w.y + q[4] * w.x * w.z + q[5] * w.y * w.z);
      const float seen = grid_.area[i] * std::sqrt(std::max(0.0f, form / 127));
      const float c = seen / std::abs(w[dominant_axis(w)]);
      float covered = 0;
      if (law == 0)
        covered = 1 - std::exp(-c);
      else if (law == 1)
        covered = std::min(c, 1.0f);
      else
        covered = 1 - (1 - std::min(c, 2.0f) / 2) * (1 - std::min(c, 2.0f) / 2);
      level.coverage[cell] = to_code(covered);
    }
  });
}

void VolumeVisibility::fill_coarser(int l) {
  Level& level = levels_[l];
  const Level& finer = levels_[l - 1];
  const bool far = light_.type == LightType::directional;
  const float scale = static_cast<float>(1 << l);
  const vec3 light = (light_.position - grid_.origin) / (grid_.cell * scale);
  const size_t stride[3] = {1, static_cast<size_t>(finer.size[0]),
                            static_cast<size_t>(finer.size[0]) * finer.size[1]};
  parallel_for(level.occupied.size(), 8192, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const uint32_t cell = level.occupied[i];
      const uint32_t x = cell % level.size[0];
      const uint32_t y = cell / level.size[0] % level.size[1];
      const uint32_t z = cell / level.size[0] / level.size[1];
      const vec3 w = far ? to_light_ : normalize_or(light - vec3(x, y, z) - 0.5f, vec3(0, 1, 0));
      const int a = dominant_axis(w);
      const size_t u = stride[(a + 1) % 3];
      const size_t v = stride[(a + 2) % 3];
      const uint16_t* c = &finer.coverage[2 * (x * stride[0] + y * stride[1] + z * stride[2])];
      float pass = 0;
      for (const size_t offset : {size_t{0}, u, v, u + v}) {
        pass += (full - c[offset]) * (full - c[offset + stride[a]]);
      }
      level.coverage[cell] = static_cast<uint16_t>(full - pass / (4 * full) + 0.5f);
    }
  });
}

float VolumeVisibility::transmittance(vec3 position, float gap) const {
  vec3 p = (position - grid_.origin) / grid_.cell;
  vec3 w = to_light_;
  float left = std::numeric_limits<float>::infinity();
  if (light_.type != LightType::directional) {
    const vec3 offset = (light_.position - position) / grid_.cell;
    left = glm::length(offset);
    w = normalize_or(offset, vec3(0, 1, 0));
  }
  const int a = dominant_axis(w);
  const int u = (a + 1) % 3;
  const int v = (a + 2) % 3;
  const float sign = w[a] > 0 ? 1.0f : -1.0f;
  // Per cell along axis a.
  const float du = w[u] / std::abs(w[a]);
  const float dv = w[v] / std::abs(w[a]);
  left *= std::abs(w[a]);  // in cells along a
  const float skip = gap * std::abs(w[a]);
  left -= skip;
  float pa = p[a] + sign * skip;
  float pu = p[u] + du * skip;
  float pv = p[v] + dv * skip;
  float pass = 1;
  // Into the grid, for receivers outside it.
  const float size_a = static_cast<float>(grid_.size[a]);
  const float enter = sign > 0 ? -pa : pa - size_a;
  if (enter > 0) {
    pa += sign * enter;
    pu += du * enter;
    pv += dv * enter;
    left -= enter;
  }
  for (int l = 0; l < volume_levels && left > 0; ++l) {
    const Level& level = levels_[l];
    const float inverse = 1.0f / static_cast<float>(1 << l);
    const size_t stride[3] = {1, static_cast<size_t>(level.size[0]),
                              static_cast<size_t>(level.size[0]) * level.size[1]};
    const int steps = l + 1 < volume_levels ? steps_level : 1 << 20;
    for (int s = 0; s < steps && left > 0; ++s) {
      const float za = pa * inverse;
      // The slab ahead.
      const int slab =
          sign > 0 ? static_cast<int>(std::floor(za)) : static_cast<int>(std::ceil(za)) - 1;
      if (slab < 0 || slab >= level.size[a]) return pass;
      const float edge = static_cast<float>(sign > 0 ? slab + 1 : slab);
      const float whole = std::abs(edge - za);
      const float part = std::min(whole, left * inverse);
      const float mu = (pu + du * 0.5f * part / inverse) * inverse - 0.5f;
      const float mv = (pv + dv * 0.5f * part / inverse) * inverse - 0.5f;
      const int iu = static_cast<int>(std::floor(mu));
      const int iv = static_cast<int>(std::floor(mv));
      if (iu >= 0 && iv >= 0 && iu + 1 < level.size[u] && iv + 1 < level.size[v]) {
        const uint16_t* c = &level.coverage[slab * stride[a] + iu * stride[u] + iv * stride[v]];
        const float fu = mu - static_cast<float>(iu);
        const float fv = mv - static_cast<float>(iv);
        const float low = c[0] + (float(c[stride[u]]) - c[0]) * fu;
        const float high = c[stride[v]] + (float(c[stride[u] + stride[v]]) - c[stride[v]]) * fu;
        const float covered = (low + (high - low) * fv) / full;
        pass *= 1 - part * covered;
        if (pass < 1e-3f) return 0;
      }
      pa += sign * part / inverse;
      pu += du * part / inverse;
      pv += dv * part / inverse;
      left -= part / inverse;
      if (part == whole) pa = edge / inverse;
    }
  }
  return pass;
}

void VolumeVisibility::visibility(const Receivers& receivers, float* visibility) const {
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
      vec3 start = p;
      float gap = gap_cells;
      if (on_surface) {
        const vec3 n(receivers.normal[0][r], receivers.normal[1][r], receivers.normal[2][r]);
        const float facing = glm::dot(n, wi);
        if (!receivers.lit_from_behind && facing <= 0) continue;
        start = p + n * (facing < 0 ? -self : self) * grid_.cell;
      }
      pass[i] = grid_.occupied.empty() ? 1.0f : transmittance(start, gap);
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
