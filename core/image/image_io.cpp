#include "core/image/image_io.h"

#include <fmt/format.h>

#include <array>
#include <memory>

#include "core/base/error.h"
#include "core/image/color_config.h"
#include "core/image/image_input.h"
#include "core/math/color.h"
#include "core/scene/io/texture_file.h"

namespace relume {
namespace {

ImageSource own_source(const std::filesystem::path& path) {
  return {path, path.string()};
}

/// The file's channels for red, green and blue.
using RgbChannels = std::array<int, 3>;

RgbChannels find_rgb(const ImageSpec& spec) {
  const RgbChannels named = {spec.channel_index("R"), spec.channel_index("G"),
                             spec.channel_index("B")};
  if (named[0] >= 0 && named[1] >= 0 && named[2] >= 0) return named;
  if (spec.channels.size() < 3) return {0, 0, 0};
  return {0, 1, 2};
}

RgbChannels find_layer(const ImageSource& source, const ImageSpec& spec,
                       const std::string& prefix) {
  RgbChannels found{};
  for (size_t i = 0; i < 3; ++i) {
    const std::string name = prefix + "RGB"[i];
    found[i] = spec.channel_index(name);
    if (found[i] < 0) {
      throw source.broken(fmt::format("there is no channel '{}'", name), "check the layer's name");
    }
  }
  return found;
}

std::vector<int> find_channels(const ImageSource& source, const ImageSpec& spec,
                               std::span<const std::string> names) {
  std::vector<int> channels;
  for (const std::string& name : names) {
    channels.push_back(spec.channel_index(name));
    if (channels.back() < 0) {
      throw source.broken(fmt::format("there is no channel '{}'", name),
                          "check the channel's name");
    }
  }
  return channels;
}

/// The three channels as scene-linear values in the display window (black outside the data).
Image read_rgb(const ImageSource& source, ImageInput& file, const RgbChannels& channels) {
  const ImageSpec& spec = file.spec();
  Image image(spec.full_width, 0);
  // Reserving touches no memory: a file that ends early costs what it holds.
  image.pixels.reserve(static_cast<size_t>(spec.full_width) * spec.full_height * 3);
  const int64_t left = int64_t{spec.x} - spec.full_x;
  const int64_t top = int64_t{spec.y} - spec.full_y;
  const auto grow = [&](int64_t rows) {
    image.height = static_cast<int>(std::clamp<int64_t>(rows, image.height, spec.full_height));
    image.pixels.resize(image.pixel_count() * 3);
  };
  file.read_rows([&](int data_y, const float* values) {
    const int64_t y = top + data_y;
    if (y < 0 || y >= spec.full_height) return;
    grow(y + 1);
    for (int data_x = 0; data_x < spec.width; ++data_x, values += spec.channels.size()) {
      const int64_t x = left + data_x;
      if (x < 0 || x >= spec.full_width) continue;
      float* pixel = image.at(static_cast<int>(x), static_cast<int>(y));
      for (size_t c = 0; c < 3; ++c) {
        const float value = values[channels[c]];
        if (!is_finite(value)) {
          throw source.broken(fmt::format("channel {} of pixel ({}, {}) is not finite",
                                          spec.channels[channels[c]], x, y),
                              "repair the image");
        }
        pixel[c] = spec.is_srgb ? linear_from_srgb(std::clamp(value, 0.0f, 1.0f)) : value;
      }
    }
  });
  grow(spec.full_height);
  return image;
}

/// One value of a texture as a byte that decodes to it: linear values are sRGB-encoded first.
uint8_t texel_byte(float value, bool encode) {
  const float clamped = std::clamp(value, 0.0f, 1.0f);
  return static_cast<uint8_t>(255.0f * (encode ? srgb_from_linear(clamped) : clamped) + 0.5f);
}

/// Any texture as sRGB-encoded bytes of the scene-linear colours that `converter` gives.
void read_converted(const ImageSource& source, ImageInput& file, const ColorConverter& converter,
                    Texture& texture) {
  const ImageSpec& spec = file.spec();
  const RgbChannels rgb = find_rgb(spec);
  file.read_rows([&](int y, const float* values) {
    for (int x = 0; x < spec.width; ++x, values += spec.channels.size()) {
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

Texture read_texture(const ImageSource& source, bool srgb, const std::string& color_space = "") {
  const std::unique_ptr<ImageInput> file = open_image(source);
  const ImageSpec& spec = file->spec();
  const RgbChannels rgb = find_rgb(spec);
  const int alpha = spec.alpha_channel;
  const bool encode = srgb && !spec.is_srgb;
  Texture texture{
      source.path.lexically_normal().generic_string(), spec.width, spec.height, srgb, {}};
  texture.texels.reserve(static_cast<size_t>(spec.width) * spec.height * 4);
  if (!color_space.empty()) {
    texture.name += "|" + color_space;
    read_converted(source, *file, ColorConverter(color_space, source.place), texture);
    return texture;
  }
  if (spec.is_bytes) {
    file->read_rows([&](int, const uint8_t* values) {
      for (int x = 0; x < spec.width; ++x, values += spec.channels.size()) {
        for (const int c : rgb) texture.texels.push_back(values[c]);
        texture.texels.push_back(alpha >= 0 ? values[alpha] : uint8_t{255});
      }
    });
    return texture;
  }
  file->read_rows([&](int y, const float* values) {
    for (int x = 0; x < spec.width; ++x, values += spec.channels.size()) {
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

Image read_image(const std::filesystem::path& path) {
  const ImageSource source = own_source(path);
  const std::unique_ptr<ImageInput> file = open_image(source);
  const RgbChannels channels = find_rgb(file->spec());
  return read_rgb(source, *file, channels);
}

Image read_exr_layer(const std::filesystem::path& path, const std::string& prefix) {
  const ImageSource source = own_source(path);
  const std::unique_ptr<ImageInput> file = open_image(source);
  const RgbChannels channels = find_layer(source, file->spec(), prefix);
  return read_rgb(source, *file, channels);
}

Image read_exr_channel(const std::filesystem::path& path, const std::string& name) {
  const ImageSource source = own_source(path);
  const std::unique_ptr<ImageInput> file = open_image(source);
  const int channel = file->spec().channel_index(name);
  if (channel < 0) {
    throw source.broken(fmt::format("there is no channel '{}'", name), "check the channel's name");
  }
  const Image rgb = read_rgb(source, *file, {channel, channel, channel});
  Image image(rgb.width, rgb.height, 1);
  for (size_t i = 0; i < image.pixel_count(); ++i) image.pixels[i] = rgb.pixels[3 * i];
  return image;
}

std::vector<std::string> read_channel_names(const std::filesystem::path& path) {
  return open_image(own_source(path))->spec().channels;
}

ImageHeader read_image_header(const std::filesystem::path& path) {
  const ImageSpec spec = open_image(own_source(path))->spec();
  return {spec.full_width, spec.full_height, spec.channels, spec.metadata};
}

void read_channel_rows(const std::filesystem::path& path, std::span<const std::string> names,
                       const std::function<void(int y, std::span<const float> values)>& row) {
  const ImageSource source = own_source(path);
  const std::unique_ptr<ImageInput> file = open_image(source);
  const ImageSpec& spec = file->spec();
  const std::vector<int> channels = find_channels(source, spec, names);
  const int64_t left = int64_t{spec.x} - spec.full_x;
  const int64_t top = int64_t{spec.y} - spec.full_y;
  std::vector<float> values(static_cast<size_t>(spec.full_width) * channels.size());
  int next = 0;
  const auto skip_to = [&](int64_t y) {
    std::fill(values.begin(), values.end(), 0.0f);
    while (next < std::min<int64_t>(y, spec.full_height)) row(next++, values);
  };
  file->read_rows([&](int data_y, const float* data) {
    skip_to(top + data_y);
    if (next != top + data_y || next >= spec.full_height) return;
    for (int64_t x = std::max<int64_t>(0, left);
         x < std::min<int64_t>(spec.full_width, left + spec.width); ++x) {
      const float* from = data + static_cast<size_t>(x - left) * spec.channels.size();
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
  const ImageSource source{path, fmt::format("{}: image '{}'", place, name)};
  scene.textures.push_back(read_texture(source, srgb, color_space));
  return static_cast<int>(scene.textures.size()) - 1;
}

int add_texture(Scene& scene, std::span<const std::byte> bytes, const std::string& name, bool srgb,
                const std::string& place) {
  if (const int found = find_texture(scene, name, srgb); found >= 0) return found;
  const bool is_png = bytes.size() > 1 && bytes[1] == std::byte{'P'};
  const ImageSource source{is_png ? "image.png" : "image.jpg", place, bytes};
  if (bytes.empty()) throw source.broken("the image is empty", "check the file");
  Texture texture = read_texture(source, srgb);
  texture.name = name;
  scene.textures.push_back(std::move(texture));
  return static_cast<int>(scene.textures.size()) - 1;
}

}  // namespace relume
