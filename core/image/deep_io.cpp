#include "core/image/deep_io.h"

#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <memory>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/mapped_file.h"
#include "core/image/exr_header.h"

namespace relume {
namespace {

constexpr int max_size_px = 16384;
constexpr int max_channels = 1024;
constexpr uint64_t max_value_bytes = uint64_t{8} << 30;
/// Pixels of a row may not hold more; also what keeps a broken file from asking for all memory.
constexpr uint64_t max_row_samples = uint64_t{1} << 26;

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.empty() ? "unknown reason" : text;
}

Error unreadable(const std::filesystem::path& path, const std::string& reason) {
  return input_error(path.string(), "cannot read the deep image: " + one_line(reason),
                     "check that the file is complete");
}

std::unique_ptr<OIIO::ImageInput> open_deep(const std::filesystem::path& path) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) {
    throw input_error(path.string(), "cannot open: there is no such file", "check the path");
  }
  const auto fault = find_exr_fault(MappedFile(path).bytes(), max_size_px);
  if (fault && fault->is_too_large) {
    throw limit_error(path.string(), fault->what,
                      fmt::format("the limit is {0} x {0}", max_size_px));
  }
  if (fault) throw unreadable(path, fault->what);
  std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path.string());
  if (!input) throw unreadable(path, OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  if (!spec.deep) throw input_error(path.string(), "holds no deep pixels", "give a deep EXR");
  if (spec.tile_width > 0) {
    throw input_error(path.string(), "is tiled", "write deep scanlines");
  }
  for (const int size : {spec.width, spec.height, spec.full_width, spec.full_height}) {
    if (size >= 1 && size <= max_size_px) continue;
    throw limit_error(path.string(), fmt::format("{} x {} pixels", spec.width, spec.height),
                      fmt::format("the limit is {0} x {0}", max_size_px));
  }
  if (spec.nchannels < 1 || spec.nchannels > max_channels) {
    throw limit_error(path.string(), fmt::format("{} channels", spec.nchannels),
                      fmt::format("the limit is {}", max_channels));
  }
  return input;
}

std::vector<int> find_channels(const std::filesystem::path& path, const OIIO::ImageSpec& spec,
                               std::span<const std::string> names) {
  std::vector<int> channels;
  for (const std::string& name : names) {
    channels.push_back(spec.channelindex(name));
    if (channels.back() >= 0) continue;
    throw input_error(path.string(), fmt::format("there is no channel '{}'", printable(name)),
                      "check the channel's name");
  }
  return channels;
}

float value_of_sample(const OIIO::DeepData& data, int64_t pixel, int channel, int sample) {
  if (data.channeltype(channel) == OIIO::TypeDesc::UINT32) {
    return static_cast<float>(data.deep_value_uint(pixel, channel, sample));
  }
  return data.deep_value(pixel, channel, sample);
}

/// Appends row y of the display window.
void append_row(const OIIO::ImageSpec& spec, const OIIO::DeepData& data,
                const std::vector<int>& channels, DeepImage& image) {
  const int64_t left = int64_t{spec.x} - spec.full_x;
  for (int64_t x = 0; x < image.width; ++x) {
    const int64_t pixel = x - left;
    const bool is_inside = pixel >= 0 && pixel < spec.width;
    const int count = is_inside ? data.samples(pixel) : 0;
    image.counts.push_back(static_cast<uint32_t>(count));
    for (int sample = 0; sample < count; ++sample) {
      for (const int channel : channels) {
        image.values.push_back(value_of_sample(data, pixel, channel, sample));
      }
    }
  }
}

void check_row(const std::filesystem::path& path, const OIIO::DeepData& data,
               const DeepImage& image, size_t channels) {
  uint64_t samples = 0;
  for (int64_t pixel = 0; pixel < data.pixels(); ++pixel) {
    samples += static_cast<uint64_t>(std::max(0, data.samples(pixel)));
  }
  const uint64_t values = image.values.size() + samples * channels;
  if (samples <= max_row_samples && values <= max_value_bytes / sizeof(float)) return;
  throw limit_error(path.string(), "the samples take more than 8 GiB", "cut the picture");
}

OIIO::ImageSpec deep_spec(const DeepImage& image,
                          const std::vector<std::pair<std::string, std::string>>& metadata) {
  OIIO::ImageSpec spec(image.width, image.height, static_cast<int>(image.channels.size()),
                       OIIO::TypeDesc::FLOAT);
  spec.deep = true;
  spec.channelnames.clear();
  spec.channelformats.clear();
  for (const DeepChannel& channel : image.channels) {
    spec.channelnames.push_back(channel.name);
    spec.channelformats.emplace_back(channel.is_half ? OIIO::TypeDesc::HALF
                                                     : OIIO::TypeDesc::FLOAT);
  }
  spec.alpha_channel = spec.channelindex("A");
  spec.z_channel = spec.channelindex("Z");
  // The only one for deep pixels beside none: others would silently become it.
  spec.attribute("compression", "zips");
  spec.attribute("oiio:ColorSpace", "Linear");
  spec.attribute("DateTime", "");
  for (const auto& [name, value] : metadata) spec.attribute(name, value);
  return spec;
}

/// Row y of the image; `values` points at its first value and ends behind its last one.
OIIO::DeepData make_row(const OIIO::ImageSpec& spec, const DeepImage& image, int y,
                        const float*& values) {
  OIIO::DeepData data;
  data.init(image.width, spec.nchannels, spec.channelformats, spec.channelnames);
  const uint32_t* counts = &image.counts[static_cast<size_t>(y) * image.width];
  data.set_all_samples(OIIO::cspan<unsigned int>(counts, image.width));
  for (int x = 0; x < image.width; ++x) {
    for (uint32_t sample = 0; sample < counts[x]; ++sample) {
      for (int c = 0; c < spec.nchannels; ++c) {
        data.set_deep_value(x, c, static_cast<int>(sample), *values++);
      }
    }
  }
  return data;
}

}  // namespace

void write_deep_exr(const std::filesystem::path& path, const DeepImage& image,
                    const std::vector<std::pair<std::string, std::string>>& metadata) {
  CHECK_MSG(image.counts.size() == image.pixel_count(), "{} counts", image.counts.size());
  const OIIO::ImageSpec spec = deep_spec(image, metadata);
  // The library opens deep files by name alone.
  AtomicFile file(path);
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create("openexr");
  if (!output) throw output_error(path.string(), one_line(OIIO::geterror()), "install OpenImageIO");
  const auto require = [&](bool ok) {
    if (!ok) {
      throw output_error(path.string(), "cannot encode: " + one_line(output->geterror()),
                         "check the folder and the disk");
    }
  };
  require(output->open(file.temporary().string(), spec));
  const float* values = image.values.data();
  for (int y = 0; y < image.height; ++y) {
    require(output->write_deep_scanlines(y, y + 1, 0, make_row(spec, image, y, values)));
  }
  require(output->close());
  file.commit();
}

bool is_deep_image(const std::filesystem::path& path) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) return false;
  if (find_exr_fault(MappedFile(path).bytes(), max_size_px)) return false;
  const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path.string());
  if (!input) OIIO::geterror();  // told by whoever reads the file
  return input && input->spec().deep;
}

DeepImage read_deep_header(const std::filesystem::path& path) {
  const auto input = open_deep(path);
  const OIIO::ImageSpec& spec = input->spec();
  DeepImage image{spec.full_width, spec.full_height, {}, {}, {}};
  for (int c = 0; c < spec.nchannels; ++c) {
    image.channels.push_back({spec.channel_name(c), spec.channelformat(c) == OIIO::TypeDesc::HALF});
  }
  return image;
}

DeepImage read_deep_image(const std::filesystem::path& path, std::span<const std::string> names) {
  const auto input = open_deep(path);
  const OIIO::ImageSpec& spec = input->spec();
  const std::vector<int> channels = find_channels(path, spec, names);
  DeepImage image{spec.full_width, spec.full_height, {}, {}, {}};
  for (size_t c = 0; c < names.size(); ++c) {
    image.channels.push_back({names[c], spec.channelformat(channels[c]) == OIIO::TypeDesc::HALF});
  }
  const int64_t top = int64_t{spec.y} - spec.full_y;
  try {
    for (int64_t y = 0; y < image.height; ++y) {
      const int64_t data_y = y - top;
      if (data_y < 0 || data_y >= spec.height) {
        image.counts.resize(image.counts.size() + image.width, 0);
        continue;
      }
      const int line = spec.y + static_cast<int>(data_y);
      OIIO::DeepData data;
      if (!input->read_native_deep_scanlines(0, 0, line, line + 1, 0, 0, spec.nchannels, data)) {
        throw unreadable(path, input->geterror());
      }
      check_row(path, data, image, channels.size());
      append_row(spec, data, channels, image);
    }
  } catch (const std::bad_alloc&) {
    throw limit_error(path.string(), "a row holds more samples than fit into memory",
                      "check that the file is complete");
  } catch (const std::length_error&) {
    throw unreadable(path, "a row says that it holds more samples than there can be");
  }
  return image;
}

}  // namespace relume
