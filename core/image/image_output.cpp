#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <functional>
#include <memory>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/file.h"
#include "core/image/image_input.h"
#include "core/image/image_io.h"

namespace relume {
namespace {

/// Pixels are encoded in bands of about this many values.
constexpr size_t most_band_values = size_t{1} << 22;

/// Encodes through OpenImageIO into memory. write(output) writes the pixels and returns success.
std::vector<unsigned char> encode_image(
    const std::filesystem::path& path, const char* format, const OIIO::ImageSpec& spec,
    const std::function<bool(OIIO::ImageOutput& output)>& write) {
  OIIO::Filesystem::IOVecOutput memory;
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(format);
  if (!output) throw output_error(path.string(), one_line(OIIO::geterror()), "install OpenImageIO");
  const bool ok = output->set_ioproxy(&memory) && output->open(format, spec) && write(*output) &&
                  output->close();
  if (!ok) {
    throw output_error(path.string(), "cannot encode: " + one_line(output->geterror()),
                       "check the image's size");
  }
  return std::move(memory.buffer());
}

void write_bytes(const std::filesystem::path& path, const std::vector<unsigned char>& bytes) {
  write_file_atomic(path, std::as_bytes(std::span(bytes)));
}

/// Rows [begin, end) of all layers side by side.
void interleave(std::span<const ExrLayer> layers, int begin, int end, std::vector<float>& band) {
  float* out = band.data();
  for (int y = begin; y < end; ++y) {
    for (int x = 0; x < layers.front().image->width; ++x) {
      for (const ExrLayer& layer : layers) {
        out = std::copy_n(layer.image->at(x, y), layer.image->channels, out);
      }
    }
  }
}

OIIO::ImageSpec exr_spec(std::span<const ExrLayer> layers,
                         const std::vector<std::pair<std::string, std::string>>& metadata) {
  const Image& first = *layers.front().image;
  OIIO::ImageSpec spec(first.width, first.height, 0, OIIO::TypeDesc::FLOAT);
  for (const ExrLayer& layer : layers) {
    const Image& image = *layer.image;
    CHECK_MSG(image.width == first.width && image.height == first.height &&
                  static_cast<size_t>(image.channels) == layer.names.size(),
              "layer '{}': {} x {} x {}, {} names", layer.prefix, image.width, image.height,
              image.channels, layer.names.size());
    for (const std::string& name : layer.names) spec.channelnames.push_back(layer.prefix + name);
  }
  spec.nchannels = static_cast<int>(spec.channelnames.size());
  spec.attribute("compression", "zip");
  spec.attribute("oiio:ColorSpace", "Linear");
  // The library would put the time of day there: the same picture gives the same bytes.
  spec.attribute("DateTime", "");
  for (const auto& [name, value] : metadata) spec.attribute(name, value);
  return spec;
}

}  // namespace

void write_exr(const std::filesystem::path& path, std::span<const ExrLayer> layers,
               const std::vector<std::pair<std::string, std::string>>& metadata) {
  CHECK(!layers.empty());
  const OIIO::ImageSpec spec = exr_spec(layers, metadata);
  const size_t row_values = static_cast<size_t>(spec.width) * spec.nchannels;
  // Whole blocks of 16 rows, the unit of zip compression.
  const int band_rows =
      static_cast<int>(std::max<size_t>(1, most_band_values / 16 / row_values)) * 16;
  std::vector<float> band(row_values * static_cast<size_t>(std::min(band_rows, spec.height)));
  write_bytes(path, encode_image(path, "exr", spec, [&](OIIO::ImageOutput& output) {
                for (int y = 0; y < spec.height; y += band_rows) {
                  const int end = std::min(spec.height, y + band_rows);
                  interleave(layers, y, end, band);
                  if (!output.write_scanlines(y, end, 0, OIIO::TypeDesc::FLOAT, band.data())) {
                    return false;
                  }
                }
                return true;
              }));
}

void write_png(const std::filesystem::path& path, const DisplayImage& image) {
  CHECK_MSG(image.channels == 3 || image.channels == 4, "channels {}", image.channels);
  OIIO::ImageSpec spec(image.width, image.height, image.channels, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  spec.attribute("oiio:UnassociatedAlpha", 1);
  write_bytes(path, encode_image(path, "png", spec, [&](OIIO::ImageOutput& output) {
                return output.write_image(OIIO::TypeDesc::UINT8, image.pixels.data());
              }));
}

}  // namespace relume
