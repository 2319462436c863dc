#include "core/image/image_io.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/mapped_file.h"
#include "core/image/color_config.h"
#include "core/image/exr_header.h"
#include "core/math/color.h"
#include "core/scene/io/texture_file.h"

namespace relume {
namespace {

constexpr int max_size_px = 16384;
constexpr int max_channels = 1024;
/// Pixels pass through memory in bands of about this many values, so that a short file with a huge
/// header fails before much is allocated.
constexpr size_t band_values = size_t{1} << 22;
constexpr std::array<std::string_view, 7> known_formats = {"openexr", "png", "jpeg", "tiff",
                                                           "targa",   "bmp", "hdr"};

/// OpenImageIO's own message on one line.
std::string one_line(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.empty() ? "unknown reason" : text;
}

/// Who asks for a file, for messages: "FILE" or "PLACE: image 'FILE'".
struct Source {
  std::filesystem::path path;
  std::string place;
  std::span<const std::byte> bytes = {};  ///< the file's, where it lies in another one

  Error broken(std::string_view what, std::string_view mend) const {
    return input_error(place, what, mend);
  }
  Error unreadable(const std::string& reason) const {
    return broken("cannot read the image: " + one_line(reason),
                  "check that the file is complete and of a known format");
  }
};

Source own_source(const std::filesystem::path& path) {
  return {path, path.string()};
}

struct OpenImage {
  std::unique_ptr<OIIO::Filesystem::IOMemReader> memory;  ///< where Source::bytes are read
  std::unique_ptr<OIIO::ImageInput> input;
  OIIO::ImageSpec spec;
};

void check_size(const Source& source, const OIIO::ImageSpec& spec) {
  for (const int size : {spec.width, spec.height, spec.full_width, spec.full_height}) {
    if (size < 1) throw source.broken("the image has no pixels", "give another image");
    if (size > max_size_px) {
      throw limit_error(source.place,
                        fmt::format("{} x {} pixels is too large", spec.width, spec.height),
                        fmt::format("the limit is {0} x {0}", max_size_px));
    }
  }
  if (spec.nchannels < 1 || spec.nchannels > max_channels) {
    throw limit_error(source.place, fmt::format("{} channels", spec.nchannels),
                      fmt::format("the limit is {}", max_channels));
  }
  if (spec.deep || spec.depth > 1) {
    throw source.broken("deep and volume images are not supported", "give a flat image");
  }
}

/// libpng reports a file that ends early to stderr by itself, so the chunks of a PNG are walked
/// first.
void check_png_complete(const Source& source, std::span<const std::byte> bytes) {
  constexpr std::string_view signature = "\x89PNG\r\n\x1a\n";
  if (bytes.size() < signature.size() ||
      std::memcmp(bytes.data(), signature.data(), signature.size()) != 0) {
    return;  // another format
  }
  size_t at = signature.size();
  while (bytes.size() - at >= 12) {
    size_t length = 0;
    for (size_t i = 0; i < 4; ++i) length = length << 8 | std::to_integer<size_t>(bytes[at + i]);
    if (length > bytes.size() - at - 12) break;
    if (std::memcmp(&bytes[at + 4], "IEND", 4) == 0) return;
    at += length + 12;
  }
  throw source.unreadable(fmt::format("the PNG file ends early, after {} bytes", bytes.size()));
}

void check_bytes(const Source& source, std::span<const std::byte> bytes) {
  check_png_complete(source, bytes);
  const auto fault = find_exr_fault(bytes, max_size_px);
  if (fault && fault->is_too_large) {
    throw limit_error(source.place, fault->what,
                      fmt::format("the limit is {0} x {0}", max_size_px));
  }
  if (fault) throw source.unreadable(fault->what);
}

/// Opens a file and checks its header; no pixel is read.
OpenImage open_image(const Source& source) {
  std::unique_ptr<OIIO::Filesystem::IOMemReader> memory;
  if (source.bytes.empty()) {
    std::error_code code;
    if (!std::filesystem::is_regular_file(source.path, code)) {
      throw source.broken("cannot open: there is no such file", "check the path");
    }
    check_bytes(source, MappedFile(source.path).bytes());
  } else {
    check_bytes(source, source.bytes);
    memory =
        std::make_unique<OIIO::Filesystem::IOMemReader>(source.bytes.data(), source.bytes.size());
  }
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  if (OIIO::Filesystem::IOProxy* proxy = memory.get()) {
    config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  }
  std::unique_ptr<OIIO::ImageInput> input =
      OIIO::ImageInput::open(source.path.string(), &config, memory.get());
  if (!input) throw source.unreadable(OIIO::geterror());
  const std::string_view format = input->format_name();
  if (std::find(known_formats.begin(), known_formats.end(), format) == known_formats.end()) {
    throw source.broken(fmt::format("the format '{}' is not supported", format),
                        "convert the image to EXR, PNG or JPEG");
  }
  OpenImage image{std::move(memory), std::move(input), {}};
  image.spec = image.input->spec();
  check_size(source, image.spec);
  return image;
}

OIIO::TypeDesc type_of(const float*) {
  return OIIO::TypeDesc::FLOAT;
}
OIIO::TypeDesc type_of(const uint8_t*) {
  return OIIO::TypeDesc::UINT8;
}

/// Reads all channels, band by band; row(y, values) gets each row, counted from the data's top.
template <class Value>
void read_rows(const Source& source, OpenImage& image,
               const std::function<void(int y, const Value* values)>& row) {
  const OIIO::ImageSpec& spec = image.spec;
  const size_t row_values = static_cast<size_t>(spec.width) * spec.nchannels;
  int band_rows = static_cast<int>(std::max<size_t>(1, band_values / row_values));
  if (spec.tile_width > 0) {
    const int tile = std::clamp(spec.tile_height, 1, max_size_px);
    band_rows = (band_rows + tile - 1) / tile * tile;
  }
  band_rows = std::min(band_rows, spec.height);
  std::vector<Value> band(row_values * static_cast<size_t>(band_rows));
  const OIIO::TypeDesc type = type_of(band.data());
  for (int top = 0; top < spec.height; top += band_rows) {
    const int bottom = std::min(spec.height, top + band_rows);
    const bool ok = spec.tile_width > 0
                        ? image.input->read_tiles(0, 0, spec.x, spec.x + spec.width, spec.y + top,
                                                  spec.y + bottom, spec.z, spec.z + 1, 0,
                                                  spec.nchannels, type, band.data())
                        : image.input->read_scanlines(0, 0, spec.y + top, spec.y + bottom, spec.z,
                                                      0, spec.nchannels, type, band.data());
    if (!ok) throw source.unreadable(image.input->geterror());
    for (int y = top; y < bottom; ++y) row(y, band.data() + row_values * (y - top));
  }
  // Some readers only note that data ended early.
  if (image.input->has_error()) throw source.unreadable(image.input->geterror());
}

/// The file's channels for red, green and blue.
using RgbChannels = std::array<int, 3>;

RgbChannels find_rgb(const OIIO::ImageSpec& spec) {
  const RgbChannels named = {spec.channelindex("R"), spec.channelindex("G"),
                             spec.channelindex("B")};
  if (named[0] >= 0 && named[1] >= 0 && named[2] >= 0) return named;
  if (spec.nchannels < 3) return {0, 0, 0};
  return {0, 1, 2};
}

RgbChannels find_layer(const Source& source, const OIIO::ImageSpec& spec,
                       const std::string& prefix) {
  RgbChannels found{};
  for (size_t i = 0; i < 3; ++i) {
    const std::string name = prefix + "RGB"[i];
    found[i] = spec.channelindex(name);
    if (found[i] < 0) {
      throw source.broken(fmt::format("there is no channel '{}'", name), "check the layer's name");
    }
  }
  return found;
}

std::vector<int> find_channels(const Source& source, const OIIO::ImageSpec& spec,
                               std::span<const std::string> names) {
  std::vector<int> channels;
  for (const std::string& name : names) {
    channels.push_back(spec.channelindex(name));
    if (channels.back() < 0) {
      throw source.broken(fmt::format("there is no channel '{}'", name),
                          "check the channel's name");
    }
  }
  return channels;
}

/// True where integer values are display-encoded. Files of 8 bits always are.
bool is_srgb_encoded(const OIIO::ImageSpec& spec) {
  if (spec.format.is_floating_point()) return false;
  return spec.format.basesize() == 1 || spec.get_string_attribute("oiio:ColorSpace") == "sRGB";
}

/// The three channels as scene-linear values in the display window (black outside the data).
Image read_rgb(const Source& source, OpenImage& file, const RgbChannels& channels) {
  const OIIO::ImageSpec& spec = file.spec;
  const bool decode = is_srgb_encoded(spec);
  Image image(spec.full_width, 0);
  // Reserving touches no memory: a file that ends early costs what it holds.
  image.pixels.reserve(static_cast<size_t>(spec.full_width) * spec.full_height * 3);
  const int64_t left = int64_t{spec.x} - spec.full_x;
  const int64_t top = int64_t{spec.y} - spec.full_y;
  const auto grow = [&](int64_t rows) {
    image.height = static_cast<int>(std::clamp<int64_t>(rows, image.height, spec.full_height));
    image.pixels.resize(image.pixel_count() * 3);
  };
  read_rows<float>(source, file, [&](int data_y, const float* values) {
    const int64_t y = top + data_y;
    if (y < 0 || y >= spec.full_height) return;
    grow(y + 1);
    for (int data_x = 0; data_x < spec.width; ++data_x, values += spec.nchannels) {
      const int64_t x = left + data_x;
      if (x < 0 || x >= spec.full_width) continue;
      float* pixel = image.at(static_cast<int>(x), static_cast<int>(y));
      for (size_t c = 0; c < 3; ++c) {
        const float value = values[channels[c]];
        if (!is_finite(value)) {
          throw source.broken(fmt::format("channel {} of pixel ({}, {}) is not finite",
                                          spec.channel_name(channels[c]), x, y),
                              "repair the image");
        }
        pixel[c] = decode ? linear_from_srgb(std::clamp(value, 0.0f, 1.0f)) : value;
      }
    }
  });
  grow(spec.full_height);
  return image;
}

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

/// One value of a texture as a byte that decodes to it: linear values are sRGB-encoded first.
uint8_t texel_byte(float value, bool encode) {
  const float clamped = std::clamp(value, 0.0f, 1.0f);
  return static_cast<uint8_t>(255.0f * (encode ? srgb_from_linear(clamped) : clamped) + 0.5f);
}

/// Any texture as sRGB-encoded bytes of the scene-linear colours that `converter` gives.
void read_converted(const Source& source, OpenImage& file, const ColorConverter& converter,
                    Texture& texture) {
  const OIIO::ImageSpec& spec = file.spec;
  const RgbChannels rgb = find_rgb(spec);
  read_rows<float>(source, file, [&](int y, const float* values) {
    for (int x = 0; x < spec.width; ++x, values += spec.nchannels) {
      std::array<float, 3> color = {values[rgb[0]], values[rgb[1]], values[rgb[2]]};
      converter.to_scene_linear(color.data());
      if (!is_finite(vec3(color[0], color[1], color[2]))) {
        throw source.broken(fmt::format("pixel ({}, {}) is not finite", x, y), "repair the image");
      }
      for (const float value : color) texture.texels.push_back(texel_byte(value, true));
      const float alpha = spec.alpha_channel >= 0 ? values[spec.alpha_channel] : 1.0f;
      texture.texels.push_back(texel_byte(is_finite(alpha) ? alpha : 1.0f, false));
    }
  });
}

Texture read_texture(const Source& source, bool srgb, const std::string& color_space = "") {
  OpenImage file = open_image(source);
  const OIIO::ImageSpec& spec = file.spec;
  const RgbChannels rgb = find_rgb(spec);
  const int alpha = spec.alpha_channel;
  const bool encode = srgb && !is_srgb_encoded(spec);
  Texture texture{
      source.path.lexically_normal().generic_string(), spec.width, spec.height, srgb, {}};
  texture.texels.reserve(static_cast<size_t>(spec.width) * spec.height * 4);
  if (!color_space.empty()) {
    texture.name += "|" + color_space;
    read_converted(source, file, ColorConverter(color_space, source.place), texture);
    return texture;
  }
  const bool bytes = spec.format == OIIO::TypeDesc::UINT8;
  if (bytes) {
    read_rows<uint8_t>(source, file, [&](int, const uint8_t* values) {
      for (int x = 0; x < spec.width; ++x, values += spec.nchannels) {
        for (const int c : rgb) texture.texels.push_back(values[c]);
        texture.texels.push_back(alpha >= 0 ? values[alpha] : uint8_t{255});
      }
    });
    return texture;
  }
  read_rows<float>(source, file, [&](int y, const float* values) {
    for (int x = 0; x < spec.width; ++x, values += spec.nchannels) {
      if (!is_finite(vec3(values[rgb[0]], values[rgb[1]], values[rgb[2]])) ||
          (alpha >= 0 && !is_finite(values[alpha]))) {
        throw source.broken(fmt::format("pixel ({}, {}) is not finite", x, y), "repair the image");
      }
      for (const int c : rgb) texture.texels.push_back(texel_byte(values[c], encode));
      texture.texels.push_back(alpha >= 0 ? texel_byte(values[alpha], false) : uint8_t{255});
    }
  });
  return texture;
}

}  // namespace

void write_exr(const std::filesystem::path& path, std::span<const ExrLayer> layers,
               const std::vector<std::pair<std::string, std::string>>& metadata) {
  CHECK(!layers.empty());
  const OIIO::ImageSpec spec = exr_spec(layers, metadata);
  const size_t row_values = static_cast<size_t>(spec.width) * spec.nchannels;
  // Whole blocks of 16 rows, the unit of zip compression.
  const int band_rows = static_cast<int>(std::max<size_t>(1, band_values / 16 / row_values)) * 16;
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

Image read_image(const std::filesystem::path& path) {
  const Source source = own_source(path);
  OpenImage file = open_image(source);
  const RgbChannels channels = find_rgb(file.spec);
  return read_rgb(source, file, channels);
}

Image read_exr_layer(const std::filesystem::path& path, const std::string& prefix) {
  const Source source = own_source(path);
  OpenImage file = open_image(source);
  const RgbChannels channels = find_layer(source, file.spec, prefix);
  return read_rgb(source, file, channels);
}

Image read_exr_channel(const std::filesystem::path& path, const std::string& name) {
  const Source source = own_source(path);
  OpenImage file = open_image(source);
  const int channel = file.spec.channelindex(name);
  if (channel < 0) {
    throw source.broken(fmt::format("there is no channel '{}'", name), "check the channel's name");
  }
  const Image rgb = read_rgb(source, file, {channel, channel, channel});
  Image image(rgb.width, rgb.height, 1);
  for (size_t i = 0; i < image.pixel_count(); ++i) image.pixels[i] = rgb.pixels[3 * i];
  return image;
}

std::vector<std::string> read_channel_names(const std::filesystem::path& path) {
  return open_image(own_source(path)).spec.channelnames;
}

ImageHeader read_image_header(const std::filesystem::path& path) {
  const OIIO::ImageSpec spec = open_image(own_source(path)).spec;
  ImageHeader header{spec.full_width, spec.full_height, spec.channelnames, {}};
  for (const OIIO::ParamValue& attribute : spec.extra_attribs) {
    if (attribute.type() != OIIO::TypeDesc::STRING) continue;
    header.metadata.emplace_back(attribute.name().string(), attribute.get_string());
  }
  return header;
}

void read_channel_rows(const std::filesystem::path& path, std::span<const std::string> names,
                       const std::function<void(int y, std::span<const float> values)>& row) {
  const Source source = own_source(path);
  OpenImage file = open_image(source);
  const OIIO::ImageSpec& spec = file.spec;
  const std::vector<int> channels = find_channels(source, spec, names);
  const int64_t left = int64_t{spec.x} - spec.full_x;
  const int64_t top = int64_t{spec.y} - spec.full_y;
  std::vector<float> values(static_cast<size_t>(spec.full_width) * channels.size());
  int next = 0;
  const auto skip_to = [&](int64_t y) {
    std::fill(values.begin(), values.end(), 0.0f);
    while (next < std::min<int64_t>(y, spec.full_height)) row(next++, values);
  };
  read_rows<float>(source, file, [&](int data_y, const float* data) {
    skip_to(top + data_y);
    if (next != top + data_y || next >= spec.full_height) return;
    for (int64_t x = std::max<int64_t>(0, left);
         x < std::min<int64_t>(spec.full_width, left + spec.width); ++x) {
      const float* from = data + static_cast<size_t>(x - left) * spec.nchannels;
      for (size_t c = 0; c < channels.size(); ++c) {
        values[static_cast<size_t>(x) * channels.size() + c] = from[channels[c]];
      }
    }
    row(next++, values);
  });
  skip_to(spec.full_height);
}

namespace {

int find_texture(const Scene& scene, const std::string& name, bool srgb) {
  for (size_t i = 0; i < scene.textures.size(); ++i) {
    if (scene.textures[i].name == name && scene.textures[i].srgb == srgb) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

}  // namespace

int add_texture(Scene& scene, const std::filesystem::path& path, bool srgb,
                const std::string& place, const std::string& color_space) {
  const std::string name = path.lexically_normal().generic_string();
  const std::string key = color_space.empty() ? name : name + "|" + color_space;
  if (const int found = find_texture(scene, key, srgb); found >= 0) return found;
  const Source source{path, fmt::format("{}: image '{}'", place, name)};
  scene.textures.push_back(read_texture(source, srgb, color_space));
  return static_cast<int>(scene.textures.size()) - 1;
}

int add_texture(Scene& scene, std::span<const std::byte> bytes, const std::string& name, bool srgb,
                const std::string& place) {
  if (const int found = find_texture(scene, name, srgb); found >= 0) return found;
  const bool is_png = bytes.size() > 1 && bytes[1] == std::byte{'P'};
  const Source source{is_png ? "image.png" : "image.jpg", place, bytes};
  if (bytes.empty()) throw source.broken("the image is empty", "check the file");
  Texture texture = read_texture(source, srgb);
  texture.name = name;
  scene.textures.push_back(std::move(texture));
  return static_cast<int>(scene.textures.size()) - 1;
}

}  // namespace relume
