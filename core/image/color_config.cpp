#include "core/image/color_config.h"

#include <OpenImageIO/color.h>
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "core/base/error.h"

namespace relume {
namespace {

constexpr const char* scene_linear_role = "scene_linear";

/// What $OCIO names. Throws Error(input) where that cannot be read.
std::unique_ptr<OIIO::ColorConfig> open_config(const std::string& place) {
  if (!has_color_config()) {
    throw input_error(place, "needs a colour configuration", "set OCIO to an OpenColorIO file");
  }
  auto config = std::make_unique<OIIO::ColorConfig>(std::getenv("OCIO"));
  if (config->has_error()) {
    throw input_error(place, "cannot read the colour configuration in OCIO: " + config->geterror(),
                      "check the file");
  }
  return config;
}

}  // namespace

bool has_color_config() {
  const char* path = std::getenv("OCIO");
  return path != nullptr && *path != '\0';
}

struct ColorConverter::Processor {
  OIIO::ColorProcessorHandle handle;
};

ColorConverter::ColorConverter(const std::string& color_space, const std::string& place)
    : processor_(std::make_unique<Processor>()) {
  const auto config = open_config(place);
  processor_->handle = config->createColorProcessor(color_space, scene_linear_role);
  if (processor_->handle) return;
  throw input_error(place,
                    fmt::format("no conversion from the colour space '{}': {}",
                                printable(color_space), config->geterror()),
                    "name one of the configuration's colour spaces");
}

ColorConverter::~ColorConverter() = default;

void ColorConverter::to_scene_linear(float* rgb) const {
  constexpr int bytes = 3 * sizeof(float);
  processor_->handle->apply(rgb, 1, 1, 3, sizeof(float), bytes, bytes);
}

Image apply_config_view(const Image& image, float exposure) {
  const auto config = open_config("the display of OCIO");
  const char* display = config->getDefaultDisplayName();
  const char* view = display != nullptr ? config->getDefaultViewName(display) : nullptr;
  if (view == nullptr) {
    throw input_error("the display of OCIO", "the configuration has none",
                      "give the configuration a display, or give --curve");
  }
  const OIIO::ColorProcessorHandle processor =
      config->createDisplayTransform(display, view, scene_linear_role);
  if (!processor) {
    throw input_error("the display of OCIO", config->geterror(), "check the configuration");
  }
  Image shown(image.width, image.height);
  const float scale = std::exp2(exposure);
  for (size_t i = 0; i < image.pixel_count(); ++i) {
    const vec3 rgb = image.rgb(i) * scale;
    std::copy_n(&rgb.x, 3, &shown.pixels[3 * i]);
  }
  constexpr OIIO::stride_t pixel_bytes = 3 * sizeof(float);
  processor->apply(shown.pixels.data(), shown.width, shown.height, 3, sizeof(float), pixel_bytes,
                   pixel_bytes * shown.width);
  return shown;
}

DisplayImage quantize_display(const Image& image) {
  DisplayImage result{image.width, image.height, image.channels, {}};
  result.pixels.reserve(image.pixels.size());
  for (const float value : image.pixels) {
    // max(0, NaN) is 0.
    const float clamped = std::min(std::max(0.0f, value), 1.0f);
    result.pixels.push_back(static_cast<uint8_t>(255.0f * clamped + 0.5f));
  }
  return result;
}

}  // namespace relume
