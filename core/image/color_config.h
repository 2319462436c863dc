#pragma once

#include <memory>
#include <string>

#include "core/image/image.h"

namespace relume {

/// True where the environment names an OpenColorIO configuration ($OCIO).
bool has_color_config();

/// Takes colours of one space to scene-linear as $OCIO says, unclamped.
class ColorConverter {
 public:
  /// `color_space`: a name or role of the configuration. Throws Error(input) naming `place` where
  /// there is no configuration, it cannot be read or has no such space.
  ColorConverter(const std::string& color_space, const std::string& place);
  ~ColorConverter();
  ColorConverter(const ColorConverter&) = delete;
  ColorConverter& operator=(const ColorConverter&) = delete;

  /// Three floats in place.
  void to_scene_linear(float* rgb) const;

 private:
  struct Processor;
  std::unique_ptr<Processor> processor_;
};

/// A scene-linear picture as the default view of $OCIO's default display shows it, times
/// 2^exposure first, unclamped: display values, RGB. Throws Error(input).
Image apply_config_view(const Image& image, float exposure);

/// Display values as 8 bits: those below 0 and not-a-number become 0, those above 1 255.
DisplayImage quantize_display(const Image& image);

}  // namespace relume
