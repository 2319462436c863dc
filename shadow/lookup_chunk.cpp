#include "shadow/lookup_chunk.h"

namespace relume {

void LookupChunk::load(const Receivers& all, int first_receiver) {
  first = first_receiver;
  count = std::min(lookup_lanes, all.count - first);
  lit_from_behind = all.lit_from_behind;
  const bool is_whole = count == lookup_lanes;
  const auto take = [&](const float* values, int i) -> const float* {
    if (values == nullptr) return nullptr;
    if (is_whole) return values + first;
    for (int lane = 0; lane < lookup_lanes; ++lane) {
      copies_[i][lane] = values[first + std::min(lane, count - 1)];
    }
    return copies_[i];
  };
  for (int axis = 0; axis < 3; ++axis) {
    position[axis] = take(all.position[axis], axis);
    normal[axis] = take(all.normal[axis], 4 + axis);
  }
  bias = take(all.bias, 3);
  for (int lane = 0; lane < lookup_lanes; ++lane) {
    lit[lane] = lane < count && all.weight[first + std::min(lane, count - 1)] > 0 ? 1.0f : 0.0f;
  }
}

void LookupChunk::mark_lit(const Light& light, vec3 to_light, float cos_outer) {
  const bool one_sided = normal[0] != nullptr && !lit_from_behind;
  const bool is_parallel = light.type == LightType::directional;
  const bool has_cone = light.type == LightType::spot;
  float lit_lanes = 0;
  for (int lane = 0; lane < lookup_lanes; ++lane) {
    const vec3 p(position[0][lane], position[1][lane], position[2][lane]);
    const vec3 wi = is_parallel ? to_light : light.position - p;
    bool sees = true;
    if (has_cone) sees = glm::dot(wi, to_light) >= cos_outer * glm::length(wi);
    if (one_sided) {
      sees &= glm::dot(vec3(normal[0][lane], normal[1][lane], normal[2][lane]), wi) > 0;
    }
    lit[lane] = sees ? lit[lane] : 0.0f;
    passed[lane] = 1;
    lit_lanes += lit[lane];
  }
  any_lit = lit_lanes > 0;
}

Receivers LookupChunk::as_receivers(const float* weights) const {
  Receivers receivers;
  receivers.count = lookup_lanes;
  receivers.weight = weights;
  for (int axis = 0; axis < 3; ++axis) {
    receivers.position[axis] = position[axis];
    receivers.normal[axis] = normal[axis];
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
