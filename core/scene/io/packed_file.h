#pragma once

#include <string_view>

#include "core/base/mapped_file.h"

namespace relume {

/// What may come out of a ".gz" file: so many bytes and so many times its own size.
inline constexpr uint64_t least_unpacked_limit = uint64_t{64} << 20;
inline constexpr uint64_t most_unpacked_times = 32;

/// A file that is read whole. One whose name ends in ".gz" is unpacked (gzip, RFC 1952).
class PackedFile {
 public:
  PackedFile() = default;
  /// Throws Error(input) where the file cannot be read or is no gzip file, Error(limit) where more
  /// comes out of it than the limits allow.
  explicit PackedFile(const std::filesystem::path& path);

  std::string_view text() const;

 private:
  MappedFile file_;
  std::string unpacked_;
  bool is_packed_ = false;
};

/// The name without ".gz".
std::filesystem::path unpacked_name(const std::filesystem::path& path);

}  // namespace relume
