#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace relume {

constexpr std::string_view jpeg_signature = "\xff\xd8\xff";

/// What a library is to see of a JPEG file, and the size that this claims to have.
struct JpegPicture {
  std::vector<std::byte> bytes;
  int width = 0;  ///< pixels, to 65535; the largest of all frames before the first scan
  int height = 0;
  int channels = 0;
};

/// A JPEG file without what is no picture: of the segments before its first scan those for
/// applications, except JFIF's and Adobe's that colours depend on, and comments are left out, and
/// what stands between segments. Libraries that look into Exif, IPTC or XMP for us get none. A
/// segment that is cut short ends the result. Source: ITU-T T.81, B.1 and B.2.2.
JpegPicture jpeg_without_metadata(std::span<const std::byte> file);

}  // namespace relume
