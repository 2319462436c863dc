#include "viewer/frames/finished_frame.h"

#include <algorithm>

#include "core/base/error.h"

namespace relume {

bool is_finished_frame(const std::filesystem::path& path, int width, int height,
                       FrameMetadata metadata) {
  std::error_code code;
  if (path.extension() != ".exr" || !std::filesystem::is_regular_file(path, code)) return false;
  try {
    ImageHeader header = read_image_header(path);
    if (header.width != width || header.height != height) return false;
    std::erase_if(header.metadata,
                  [](const auto& attribute) { return !attribute.first.starts_with("relume:"); });
    // A file holds no empty attributes.
    std::erase_if(metadata, [](const auto& attribute) { return attribute.second.empty(); });
    std::erase_if(header.metadata, [](const auto& attribute) { return attribute.second.empty(); });
    std::sort(header.metadata.begin(), header.metadata.end());
    std::sort(metadata.begin(), metadata.end());
    if (header.metadata != metadata) return false;
    read_channel_rows(path, header.channels, [](int, std::span<const float>) {});
    return true;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace relume
