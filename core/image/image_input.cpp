#include "core/image/image_input.h"

#include <OpenImageIO/filesystem.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "core/base/mapped_file.h"
#include "core/image/decoder_process.h"
#include "core/image/exr_header.h"
#include "core/image/jpeg_segments.h"
#include "core/image/scanlines.h"

namespace relume {
namespace {

/// Pixels pass through memory in bands of about this many values, small ones first, so that a short
/// file with a huge header fails before much is allocated.
constexpr size_t first_band_values = size_t{1} << 16;
constexpr size_t most_band_values = size_t{1} << 22;

/// What a byte of a PNG, JPEG, TIFF, BMP, Targa or HDR file can stand for: deflate ends at 1032.
constexpr uint64_t most_bytes_a_byte = 2000;

/// A format by OpenImageIO's name of it, empty: none that is known.
struct Format {
  std::string_view name;
  bool is_decoded_here = false;
};

bool starts_with(std::span<const std::byte> bytes, std::string_view signature) {
  return bytes.size() >= signature.size() &&
         std::memcmp(bytes.data(), signature.data(), signature.size()) == 0;
}

bool is_named_targa(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".tga" || extension == ".tpic";
}

constexpr std::string_view png_signature = "\x89PNG\r\n\x1a\n";

Format find_format(const ImageSource& source, std::span<const std::byte> bytes) {
  using namespace std::string_view_literals;
  if (starts_with(bytes, "\x76\x2f\x31\x01")) return {"openexr", true};
  if (starts_with(bytes, png_signature)) return {"png", true};
  if (starts_with(bytes, jpeg_signature)) return {"jpeg", true};
  for (const std::string_view signature : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv}) {
    if (starts_with(bytes, signature)) return {"tiff"};
  }
  if (starts_with(bytes, "BM")) return {"bmp"};
  if (starts_with(bytes, "#?")) return {"hdr"};
  return {is_named_targa(source.path) ? "targa"sv : ""sv};
}

/// libpng reports a file that ends early to stderr by itself, so the chunks of a PNG are walked
/// first.
void check_png_complete(const ImageSource& source, std::span<const std::byte> bytes) {
  size_t at = png_signature.size();
  while (bytes.size() - at >= 12) {
    size_t length = 0;
    for (size_t i = 0; i < 4; ++i) length = length << 8 | std::to_integer<size_t>(bytes[at + i]);
    if (length > bytes.size() - at - 12) break;
    if (std::memcmp(&bytes[at + 4], "IEND", 4) == 0) return;
    at += length + 12;
  }
  throw source.unreadable(fmt::format("the PNG file ends early, after {} bytes", bytes.size()));
}

Format check_bytes(const ImageSource& source, std::span<const std::byte> bytes) {
  const Format format = find_format(source, bytes);
  if (format.name.empty()) {
    throw source.broken("cannot read the image: it is of no format that is known",
                        "convert the image to EXR, PNG or JPEG");
  }
  if (format.name == "png") check_png_complete(source, bytes);
  if (const auto fault = find_exr_fault(bytes, max_image_px)) {
    if (!fault->is_too_large) throw source.unreadable(fault->what);
    throw limit_error(source.place, fault->what,
                      fmt::format("the limit is {0} x {0}", max_image_px));
  }
  return format;
}

Format check_source(const ImageSource& source) {
  if (!source.bytes.empty()) return check_bytes(source, source.bytes);
  std::error_code code;
  if (!std::filesystem::is_regular_file(source.path, code)) {
    throw source.broken("cannot open: there is no such file", "check the path");
  }
  return check_bytes(source, MappedFile(source.path).bytes());
}

void check_size(const ImageSource& source, int width, int height) {
  if (width < 1 || height < 1) throw source.broken("the image has no pixels", "give another image");
  if (std::max(width, height) > max_image_px) {
    throw limit_error(source.place, fmt::format("{} x {} pixels is too large", width, height),
                      fmt::format("the limit is {0} x {0}", max_image_px));
  }
}

void check_spec(const ImageSource& source, const OIIO::ImageSpec& spec) {
  check_size(source, spec.width, spec.height);
  check_size(source, spec.full_width, spec.full_height);
  if (spec.nchannels < 1 || spec.nchannels > max_image_channels) {
    throw limit_error(source.place, fmt::format("{} channels", spec.nchannels),
                      fmt::format("the limit is {}", max_image_channels));
  }
  if (spec.deep || spec.depth > 1) {
    throw source.broken("deep and volume images are not supported", "give a flat image");
  }
}

ImageSpec own_spec(const OIIO::ImageSpec& from) {
  ImageSpec spec;
  spec.width = from.width;
  spec.height = from.height;
  spec.x = from.x;
  spec.y = from.y;
  spec.full_width = from.full_width;
  spec.full_height = from.full_height;
  spec.full_x = from.full_x;
  spec.full_y = from.full_y;
  spec.alpha_channel = from.alpha_channel;
  spec.is_bytes = from.format == OIIO::TypeDesc::UINT8;
  spec.is_srgb =
      !from.format.is_floating_point() &&
      (from.format.basesize() == 1 || from.get_string_attribute("oiio:ColorSpace") == "sRGB");
  spec.channels = from.channelnames;
  for (const OIIO::ParamValue& attribute : from.extra_attribs) {
    if (attribute.type() != OIIO::TypeDesc::STRING) continue;
    spec.metadata.emplace_back(attribute.name().string(), attribute.get_string());
  }
  return spec;
}

OIIO::TypeDesc type_of(const float*) {
  return OIIO::TypeDesc::FLOAT;
}
OIIO::TypeDesc type_of(const uint8_t*) {
  return OIIO::TypeDesc::UINT8;
}

/// Decodes by OpenImageIO in this process.
class DirectInput : public ImageInput {
 public:
  DirectInput(const ImageSource& source, std::string_view format) : source_(source) {
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    std::span<const std::byte> bytes = source.bytes;
    if (format == "jpeg") {
      jpeg_ = bytes.empty() ? jpeg_without_metadata(MappedFile(source.path).bytes())
                            : jpeg_without_metadata(bytes);
      // libjpeg takes memory for all of the picture when it is opened.
      check_size(source, jpeg_.width, jpeg_.height);
      check_ratio(uint64_t{1} * jpeg_.width * jpeg_.height * jpeg_.channels, jpeg_.width,
                  jpeg_.height);
      bytes = jpeg_.bytes;
    }
    if (!bytes.empty()) {
      memory_ = std::make_unique<OIIO::Filesystem::IOMemReader>(bytes.data(), bytes.size());
      OIIO::Filesystem::IOProxy* proxy = memory_.get();
      config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    }
    input_ = OIIO::ImageInput::create(std::string(format));
    if (!input_) throw source.unreadable(OIIO::geterror());
    if (!input_->open(source.path.string(), library_spec_, config)) {
      throw source.unreadable(input_->geterror());
    }
    check_spec(source, library_spec_);
    spec_ = own_spec(library_spec_);
    if (format != "openexr") {  // whose tables were walked
      check_ratio(library_spec_.image_bytes(true), spec_.width, spec_.height);
    }
  }

  void read_rows(const std::function<void(int y, const float* values)>& row) override {
    read_bands<float>(row);
  }
  void read_rows(const std::function<void(int y, const uint8_t* values)>& row) override {
    read_bands<uint8_t>(row);
  }

 private:
  void check_ratio(uint64_t image_bytes, int width, int height) const {
    std::error_code code;
    const uint64_t file_bytes = source_.bytes.empty()
                                    ? std::filesystem::file_size(source_.path, code)
                                    : source_.bytes.size();
    if (image_bytes / most_bytes_a_byte > file_bytes) {
      throw source_.unreadable(
          fmt::format("{} bytes are too few for {} x {} pixels", file_bytes, width, height));
    }
  }

  /// Rows of about `values` values: whole tiles, where there are tiles.
  int band_rows(size_t values) const {
    const OIIO::ImageSpec& spec = library_spec_;
    int rows = static_cast<int>(std::max<size_t>(1, values / spec_.row_values()));
    if (spec.tile_width > 0) {
      const int tile = std::clamp(spec.tile_height, 1, max_image_px);
      rows = (rows + tile - 1) / tile * tile;
    }
    return rows;
  }

  template <class Value>
  void read_bands(const std::function<void(int y, const Value* values)>& row) {
    const int height = library_spec_.height;
    std::vector<Value> band;
    size_t band_values = first_band_values;
    for (int top = 0; top < height; band_values = std::min(2 * band_values, most_band_values)) {
      const int bottom =
          static_cast<int>(std::min<int64_t>(height, int64_t{top} + band_rows(band_values)));
      band.resize(std::max(band.size(), spec_.row_values() * static_cast<size_t>(bottom - top)));
      read_band(top, bottom, band.data());
      for (int y = top; y < bottom; ++y) row(y, band.data() + spec_.row_values() * (y - top));
      top = bottom;
    }
    // Some readers only note that data ended early.
    if (input_->has_error()) throw source_.unreadable(input_->geterror());
  }

  template <class Value>
  void read_band(int top, int bottom, Value* values) {
    const OIIO::ImageSpec& spec = library_spec_;
    const int y = spec.y + top;
    const int y_end = spec.y + bottom;
    const OIIO::TypeDesc type = type_of(values);
    const bool ok =
        spec.tile_width > 0
            ? input_->read_tiles(0, 0, spec.x, spec.x + spec.width, y, y_end, spec.z, spec.z + 1, 0,
                                 spec.nchannels, type, values)
            : read_scanlines_as(*input_, spec, y, y_end, 0, spec.nchannels, type, values, native_);
    if (!ok) throw source_.unreadable(input_->geterror());
  }

  ImageSource source_;
  JpegPicture jpeg_;  ///< of which `memory_` reads
  std::unique_ptr<OIIO::Filesystem::IOMemReader> memory_;
  std::unique_ptr<OIIO::ImageInput> input_;
  OIIO::ImageSpec library_spec_;
  std::vector<std::byte> native_;  ///< rows as they are stored
};

}  // namespace

std::string one_line(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.empty() ? "unknown reason" : text;
}

Error ImageSource::unreadable(const std::string& reason) const {
  return broken("cannot read the image: " + one_line(reason),
                "check that the file is complete and of a known format");
}

int ImageSpec::channel_index(std::string_view name) const {
  const auto found = std::ranges::find(channels, name);
  return found == channels.end() ? -1 : static_cast<int>(found - channels.begin());
}

std::unique_ptr<ImageInput> open_image(const ImageSource& source) {
  const Format format = check_source(source);
  if (format.is_decoded_here) return std::make_unique<DirectInput>(source, format.name);
  if (source.bytes.empty()) return open_in_decoder(source);
  throw source.broken(fmt::format("is an image of the format '{}'", format.name),
                      "use PNG or JPEG inside other files");
}

std::unique_ptr<ImageInput> open_image_here(const ImageSource& source) {
  return std::make_unique<DirectInput>(source, check_source(source).name);
}

}  // namespace relume
