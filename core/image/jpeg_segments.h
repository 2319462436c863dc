#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace relume {

constexpr std::string_view jpeg_signature = "\xff\xd8\xff";

/// A JPEG file without what is no picture: of the segments before its first scan those for
/// applications, except JFIF's and Adobe's that colours depend on, and comments are left out, and
/// what stands between segments. Libraries that look into Exif, IPTC or XMP for us get none. A
/// segment that is cut short ends the result. Source: ITU-T T.81, B.1.
std::vector<std::byte> jpeg_without_metadata(std::span<const std::byte> file);

}  // namespace relume
