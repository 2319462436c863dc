#include "core/scene/io/alpha_mask.h"

#include "core/base/check.h"

namespace relume {

bool has_transparency(const Texture& texture) {
  for (size_t i = 3; i < texture.texels.size(); i += 4) {
    if (texture.texels[i] != 255) return true;
  }
  return false;
}

void set_alpha_mask(const Scene& scene, int texture, Material& material) {
  CHECK(texture >= 0 && static_cast<size_t>(texture) < scene.textures.size());
  material.alpha_texture = texture;
  material.alpha_from_luminance = !has_transparency(scene.textures[texture]);
}

}  // namespace relume
