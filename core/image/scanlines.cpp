#include "core/image/scanlines.h"

namespace relume {

bool read_scanlines_as(OIIO::ImageInput& input, const OIIO::ImageSpec& spec, int y, int y_end,
                       int first_channel, int channels, OIIO::TypeDesc type, void* out,
                       std::vector<std::byte>& native) {
  const int end_channel = first_channel + channels;
  const int rows = y_end - y;
  const auto pixel_bytes =
      static_cast<OIIO::stride_t>(spec.pixel_bytes(first_channel, end_channel, true));  // as stored
  const OIIO::stride_t row_bytes = pixel_bytes * spec.width;
  native.resize(static_cast<size_t>(row_bytes) * static_cast<size_t>(rows));
  if (!input.read_native_scanlines(0, 0, y, y_end, spec.z, first_channel, end_channel,
                                   native.data())) {
    return false;
  }
  const auto value_bytes = static_cast<OIIO::stride_t>(type.size());
  const OIIO::stride_t out_pixel_bytes = value_bytes * channels;
  const auto convert = [&](int channel, int count, const std::byte* from) {
    std::byte* to = static_cast<std::byte*>(out) + value_bytes * (channel - first_channel);
    return OIIO::convert_image(count, spec.width, rows, 1, from, spec.channelformat(channel),
                               pixel_bytes, row_bytes, 0, to, type, out_pixel_bytes,
                               out_pixel_bytes * spec.width, 0);
  };
  if (spec.channelformats.empty()) return convert(first_channel, channels, native.data());
  const std::byte* from = native.data();
  for (int channel = first_channel; channel < end_channel; ++channel) {
    if (!convert(channel, 1, from)) return false;
    from += spec.channelformat(channel).size();
  }
  return true;
}

}  // namespace relume
