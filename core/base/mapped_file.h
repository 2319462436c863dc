#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

namespace relume {

/// A read-only memory-mapped file. Empty files map to an empty span. Reading behind an end that
/// another program has moved since raises SIGBUS: see install_mapping_guard().
class MappedFile {
 public:
  MappedFile() = default;
  /// Throws Error(input) when `path` cannot be opened or mapped.
  explicit MappedFile(const std::filesystem::path& path);
  ~MappedFile();
  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;

  std::span<const std::byte> bytes() const { return {data_, size_}; }

 private:
  const std::byte* data_ = nullptr;
  size_t size_ = 0;
};

/// Makes a read of a mapped file that another program has shortened, or whose disk has failed, end
/// the process with one line that names the file and exit code 3. Process-wide, for programs: a
/// library leaves signals to its user.
void install_mapping_guard();

}  // namespace relume
