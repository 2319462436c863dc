#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "core/image/image.h"
#include "core/image/view_table.h"

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

/// How the default view of $OCIO's default display shows scene-linear colours. Immutable.
class ConfigView {
 public:
  /// Throws Error(input) where there is no configuration, it cannot be read or has no display.
  ConfigView();
  ~ConfigView();
  ConfigView(const ConfigView&) = delete;
  ConfigView& operator=(const ConfigView&) = delete;

  /// Triples in place, unclamped; the same for a triple whatever its neighbours. Thread-safe.
  void apply(std::span<float> rgb) const;

  /// The same, quick and less exact; made when first asked for. Thread-safe.
  const ViewTable& table() const;

 private:
  struct Processor;
  std::unique_ptr<Processor> processor_;
  mutable std::once_flag table_made_;
  mutable std::unique_ptr<const ViewTable> table_;
};

/// The ConfigView of the environment as it is now, read once for each configuration and choice of
/// displays and views, and kept. Throws as its constructor does. Thread-safe.
const ConfigView& config_view();

/// A scene-linear picture as config_view() shows it, times 2^exposure first, unclamped: display
/// values, RGB. Throws Error(input). Parallel.
Image apply_config_view(const Image& image, float exposure);

/// A display value as 8 bits: one below 0 and not-a-number become 0, one above 1 255.
inline uint8_t quantize_display(float value) {
  const float clamped = std::min(std::max(0.0f, value), 1.0f);  // max(0, NaN) is 0
  return static_cast<uint8_t>(255.0f * clamped + 0.5f);
}

/// All values of an image.
DisplayImage quantize_display(const Image& image);

}  // namespace relume
