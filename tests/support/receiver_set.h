#pragma once

#include <vector>

#include "core/relight/visibility.h"

namespace relume::test {

/// Receivers in arrays of their own, all on strands or all on surfaces.
struct ReceiverSet {
  std::vector<float> weight, x, y, z, nx, ny, nz, bias;

  void add(vec3 p, vec3 n, float bias_value, float w = 1) {
    weight.push_back(w);
    x.push_back(p.x);
    y.push_back(p.y);
    z.push_back(p.z);
    nx.push_back(n.x);
    ny.push_back(n.y);
    nz.push_back(n.z);
    bias.push_back(bias_value);
  }

  /// scale * position, scale * bias.
  ReceiverSet scaled(float scale) const {
    ReceiverSet set = *this;
    for (auto* values : {&set.x, &set.y, &set.z, &set.bias}) {
      for (float& value : *values) value *= scale;
    }
    return set;
  }

  Receivers view(bool surface, bool lit_from_behind = false) const {
    Receivers receivers;
    receivers.count = static_cast<int>(weight.size());
    receivers.weight = weight.data();
    receivers.position[0] = x.data();
    receivers.position[1] = y.data();
    receivers.position[2] = z.data();
    if (surface) {
      receivers.normal[0] = nx.data();
      receivers.normal[1] = ny.data();
      receivers.normal[2] = nz.data();
    }
    receivers.bias = bias.data();
    receivers.lit_from_behind = lit_from_behind;
    return receivers;
  }

  Bounds bounds() const {
    Bounds box;
    for (size_t i = 0; i < x.size(); ++i) box.extend({x[i], y[i], z[i]});
    return box;
  }

  std::vector<float> ask(VisibilitySource& source, const Light& light, bool surface = false) const {
    source.prepare(light);
    std::vector<float> visibility(weight.size(), -1.0f);
    source.visibility(view(surface), visibility.data());
    return visibility;
  }
};

}  // namespace relume::test
