#include "shadow/lookup_chunk.h"

namespace relume {

void LookupChunk::load(const Receivers& all, int first_receiver) {
  first = first_receiver;
  count = std::min(lookup_lanes, all.count - first);
  on_surface = all.normal[0] != nullptr;
  lit_from_behind = all.lit_from_behind;
  for (int lane = 0; lane < lookup_lanes; ++lane) {
    const int i = first + std::min(lane, count - 1);
    for (int axis = 0; axis < 3; ++axis) {
      position[axis][lane] = all.position[axis][i];
      if (on_surface) normal[axis][lane] = all.normal[axis][i];
    }
    bias[lane] = all.bias[i];
    lit[lane] = lane < count && all.weight[i] > 0 ? 1.0f : 0.0f;
  }
}

void LookupChunk::mark_lit(const Light& light, vec3 to_light, float cos_outer) {
  any_lit = false;
  for (int lane = 0; lane < lookup_lanes; ++lane) {
    vec3 wi = to_light;
    if (light.type != LightType::directional) {
      wi = light.position - vec3(position[0][lane], position[1][lane], position[2][lane]);
    }
    bool sees = lit[lane] > 0;
    if (light.type == LightType::spot) {
      sees = sees && glm::dot(wi, to_light) >= cos_outer * glm::length(wi);
    }
    if (on_surface && !lit_from_behind) {
      const vec3 n(normal[0][lane], normal[1][lane], normal[2][lane]);
      sees = sees && glm::dot(n, wi) > 0;
    }
    lit[lane] = sees ? 1.0f : 0.0f;
    passed[lane] = 1;
    any_lit = any_lit || sees;
  }
}

Receivers LookupChunk::as_receivers(const float* weights) const {
  Receivers receivers;
  receivers.count = lookup_lanes;
  receivers.weight = weights;
  for (int axis = 0; axis < 3; ++axis) {
    receivers.position[axis] = position[axis];
    receivers.normal[axis] = on_surface ? normal[axis] : nullptr;
  }
  receivers.bias = bias;
  receivers.lit_from_behind = lit_from_behind;
  return receivers;
}

void LookupChunk::store(float* visibility) const {
  for (int lane = 0; lane < count; ++lane) {
    visibility[first + lane] = lit[lane] > 0 ? passed[lane] : 1.0f;
  }
}

}  // namespace relume
