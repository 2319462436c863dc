#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

namespace relume {

/// Writes a file so that readers see the old or the new one, never a part: everything goes to a
/// temporary beside `path`; commit() flushes it to disk (fsync), renames it over `path` and syncs
/// the folder. Without commit() the destructor removes the temporary and `path` stays as it was.
/// Several writers of one path, threads or processes, do not disturb each other: the last one wins.
/// The first AtomicFile of a process in a folder removes what killed writers left there.
class AtomicFile {
 public:
  /// Throws Error(output) when the folder is missing or not writable.
  explicit AtomicFile(const std::filesystem::path& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Appends at the end. Throws Error(output), for instance on a full disk.
  void append(std::span<const std::byte> bytes);
  /// Overwrites bytes already written, at `offset` from the start.
  void write_at(uint64_t offset, std::span<const std::byte> bytes);
  uint64_t size() const { return size_; }
  void commit();

  /// The temporary's path, for libraries that insist on opening a file themselves.
  const std::filesystem::path& temporary() const { return temporary_; }

 private:
  std::filesystem::path path_;
  std::filesystem::path temporary_;
  int descriptor_ = -1;
  uint64_t size_ = 0;
};

/// Writes `bytes` to `path` through an AtomicFile.
void write_file_atomic(const std::filesystem::path& path, std::span<const std::byte> bytes);
void write_file_atomic(const std::filesystem::path& path, const std::string& text);

/// Makes a folder and those above it, where missing. Throws Error(output).
void make_folder(const std::filesystem::path& folder);

/// The whole of a text file. Throws Error(input) when it cannot be read and Error(limit) when it is
/// larger than `max_bytes`.
std::string read_text_file(const std::filesystem::path& path, uint64_t max_bytes);

}  // namespace relume
