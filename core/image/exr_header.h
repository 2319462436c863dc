#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace relume {

struct ExrFault {
  std::string what;           ///< in words
  bool is_too_large = false;  ///< right, but beyond the limit
};

/// What is wrong with the header of an OpenEXR file; nothing when it is right, or when the bytes
/// are of another format. Looks at what OpenEXR would take memory for before it notices that
/// the file does not hold it: attributes that are longer than the file, pictures beyond
/// `max_size_px` a side, tiles, previews, and offset tables. Source: "OpenEXR File Layout".
std::optional<ExrFault> find_exr_fault(std::span<const std::byte> file, int max_size_px);

}  // namespace relume
