#include "viewer/frames/compare_frame.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <set>

#include "core/base/error.h"

namespace relume {
namespace {

std::vector<std::string> names_of(const FrameLayers& frame) {
  std::vector<std::string> names;
  for (const ExrLayer& layer : frame.layers) {
    for (const std::string& name : layer.names) names.push_back(layer.prefix + name);
  }
  return names;
}

void check_shape(const std::filesystem::path& path, const FrameLayers& expected,
                 const std::vector<std::string>& names) {
  const ImageHeader header = read_image_header(path);
  const Image& picture = *expected.layers.front().image;
  if (header.width != picture.width || header.height != picture.height) {
    throw input_error(path.string(),
                      fmt::format("{} x {} pixels instead of {} x {}", header.width, header.height,
                                  picture.width, picture.height),
                      "render the frame again");
  }
  const std::set<std::string> known(names.begin(), names.end());
  for (const std::string& name : header.channels) {
    if (known.count(name) > 0) continue;
    throw input_error(path.string(), fmt::format("the channel '{}' is not the frame's", name),
                      "render the frame again");
  }
}

void note_difference(FrameDifference& difference, const std::string& channel, int x, int y,
                     float found, float expected) {
  if (difference.values++ == 0) {
    difference.channel = channel;
    difference.x = x;
    difference.y = y;
    difference.found = found;
    difference.expected = expected;
  }
  const double distance = std::abs(double{found} - double{expected});
  const double bounded =
      std::isfinite(distance) ? distance : std::numeric_limits<double>::infinity();
  difference.largest = std::max(difference.largest, bounded);
}

}  // namespace

std::optional<FrameDifference> compare_frame(const std::filesystem::path& path,
                                             const FrameLayers& expected) {
  const std::vector<std::string> names = names_of(expected);
  check_shape(path, expected, names);
  FrameDifference difference;
  read_channel_rows(path, names, [&](int y, std::span<const float> values) {
    const float* found = values.data();
    for (int x = 0; x < expected.layers.front().image->width; ++x) {
      size_t channel = 0;
      for (const ExrLayer& layer : expected.layers) {
        const float* pixel = layer.image->at(x, y);
        for (int c = 0; c < layer.image->channels; ++c, ++found, ++channel) {
          if (std::bit_cast<uint32_t>(*found) == std::bit_cast<uint32_t>(pixel[c])) continue;
          note_difference(difference, names[channel], x, y, *found, pixel[c]);
        }
      }
    }
  });
  if (difference.values == 0) return std::nullopt;
  return difference;
}

}  // namespace relume
