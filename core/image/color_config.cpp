#include "core/image/color_config.h"

#include <OpenImageIO/color.h>
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <map>

#include "core/base/error.h"
#include "core/base/parallel.h"

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

/// Triples in place.
void apply_processor(const OIIO::ColorProcessor& processor, std::span<float> rgb) {
  constexpr OIIO::stride_t pixel_bytes = 3 * sizeof(float);
  const int count = static_cast<int>(rgb.size() / 3);
  processor.apply(rgb.data(), count, 1, 3, sizeof(float), pixel_bytes, pixel_bytes * count);
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
  apply_processor(*processor_->handle, {rgb, 3});
}

struct ConfigView::Processor {
  OIIO::ColorProcessorHandle handle;
};

ConfigView::ConfigView() : processor_(std::make_unique<Processor>()) {
  const std::string place = "the display of OCIO";
  const auto config = open_config(place);
  const char* display = config->getDefaultDisplayName();
  const char* view = display != nullptr ? config->getDefaultViewName(display) : nullptr;
  if (view == nullptr) {
    throw input_error(place, "the configuration has none",
                      "give the configuration a display, or give --curve");
  }
  processor_->handle = config->createDisplayTransform(display, view, scene_linear_role);
  if (!processor_->handle) throw input_error(place, config->geterror(), "check the configuration");
}

ConfigView::~ConfigView() = default;

void ConfigView::apply(std::span<float> rgb) const {
  apply_processor(*processor_->handle, rgb);
}

const ViewTable& ConfigView::table() const {
  std::call_once(table_made_, [this] {
    table_ = std::make_unique<const ViewTable>([this](std::span<float> rgb) { apply(rgb); });
  });
  return *table_;
}

const ConfigView& config_view() {
  static std::mutex mutex;
  static std::map<std::string, std::unique_ptr<const ConfigView>> views;
  std::string key;
  for (const char* name : {"OCIO", "OCIO_ACTIVE_DISPLAYS", "OCIO_ACTIVE_VIEWS"}) {
    const char* value = std::getenv(name);
    key += value != nullptr ? value : "";
    key += '\n';
  }
  const std::lock_guard lock(mutex);
  std::unique_ptr<const ConfigView>& view = views[key];
  if (!view) view = std::make_unique<const ConfigView>();
  return *view;
}

Image apply_config_view(const Image& image, float exposure) {
  const ConfigView& view = config_view();
  Image shown(image.width, image.height);
  const float scale = std::exp2(exposure);
  parallel_for(image.pixel_count(), 2048, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const vec3 rgb = image.rgb(i) * scale;
      std::copy_n(&rgb.x, 3, &shown.pixels[3 * i]);
    }
    view.apply(std::span(shown.pixels).subspan(3 * begin, 3 * (end - begin)));
  });
  return shown;
}

DisplayImage quantize_display(const Image& image) {
  DisplayImage result{image.width, image.height, image.channels, {}};
  result.pixels.reserve(image.pixels.size());
  for (const float value : image.pixels) result.pixels.push_back(quantize_display(value));
  return result;
}

}  // namespace relume
