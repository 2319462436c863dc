#pragma once

#include <OpenImageIO/imageio.h>

#include <cstddef>
#include <vector>

namespace relume {

/// Reads rows [y, y_end) of an untiled image, channels [first_channel, first_channel + channels),
/// into `out` as `type`, interleaved. `native` keeps the rows as they are stored.
/// ImageInput::read_scanlines does the same with 64 MiB of its own for each call. False where
/// input.geterror() tells why.
bool read_scanlines_as(OIIO::ImageInput& input, const OIIO::ImageSpec& spec, int y, int y_end,
                       int first_channel, int channels, OIIO::TypeDesc type, void* out,
                       std::vector<std::byte>& native);

}  // namespace relume
