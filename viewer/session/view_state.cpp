#include "viewer/session/view_state.h"

namespace relume {

bool same_lighting(std::span<const Light> a, std::span<const Light> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Light& x, const Light& y) {
    return same_layer(x, y) && x.weight() == y.weight();
  });
}

}  // namespace relume
