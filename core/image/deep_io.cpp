#include "core/image/deep_io.h"

#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <memory>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/file.h"
#include "core/image/exr_rows.h"
#include "core/image/image_input.h"

namespace relume {
namespace {

ExrRows open_deep(const std::filesystem::path& path) {
  ExrRows rows(path);
  if (rows.is_deep()) return rows;
  throw input_error(path.string(), "holds no deep pixels", "give a deep EXR");
}

DeepImage header_of(const ExrRows& rows, std::span<const std::string> channels) {
  DeepImage image{rows.width(), rows.height(), {}, {}, {}};
  for (const std::string& channel : channels) {
    image.channels.push_back({channel, rows.is_half(channel)});
  }
  return image;
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

DeepImage read_deep_header(const std::filesystem::path& path) {
  const ExrRows rows = open_deep(path);
  return header_of(rows, rows.channels());
}

DeepImage read_deep_image(const std::filesystem::path& path, std::span<const std::string> names) {
  ExrRows rows = open_deep(path);
  rows.choose(names);
  DeepImage image = header_of(rows, names);
  ExrRowValues read = rows.read(0, image.height);
  image.counts = std::move(read.counts);
  image.values = std::move(read.values);
  return image;
}

}  // namespace relume
