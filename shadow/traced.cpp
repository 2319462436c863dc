#include "shadow/traced.h"

namespace relume {

void TracedVisibility::visibility(const Receivers& receivers, float* visibility) const {
  const bool on_surface = receivers.normal[0] != nullptr;
  for (int i = 0; i < receivers.count; ++i) {
    visibility[i] = 1;
    if (!(receivers.weight[i] > 0)) continue;
    const vec3 position(receivers.position[0][i], receivers.position[1][i],
                        receivers.position[2][i]);
    vec3 normal(0);
    if (on_surface) {
      normal = vec3(receivers.normal[0][i], receivers.normal[1][i], receivers.normal[2][i]);
    }
    visibility[i] = rays_.sees(position, on_surface ? &normal : nullptr, receivers.lit_from_behind,
                               receivers.bias[i])
                        ? 1.0f
                        : 0.0f;
  }
}

}  // namespace relume
