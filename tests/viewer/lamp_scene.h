#pragma once

namespace relume::test {

/// 48 x 40 pixels: a ball that emits (2, 1, 0.5) before one of clay, and two lights.
inline constexpr const char* lamp_scene = R"({"image": {"width": 48, "height": 40},
  "camera": {"eye": [0, 0, 5], "target": [0, 0, 0], "fov_y_deg": 40},
  "materials": [{"name": "glow", "shader": "lambert", "diffuse": 0.2, "emission": [2, 1, 0.5]},
                {"name": "clay", "shader": "lambert", "diffuse": 0.6}],
  "geometry": [{"name": "a", "generator": "sphere", "material": "glow"},
               {"name": "b", "generator": "sphere", "material": "clay",
                "transform": {"translate": [1, 0.3, -1]}}],
  "lights": [{"name": "key", "position": [2, 3, 4], "gain": 20},
             {"name": "rim", "position": [-3, 1, -2], "gain": 30}]})";

}  // namespace relume::test
