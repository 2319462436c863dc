#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace relume {

/// A small file whose bytes processes lock one by one, on one machine or on several that share its
/// folder. The system takes back what a process held as soon as it ends, however it ends. Contents
/// that are read under a lock are what the last holder wrote (NFS version 4 gives this too). Every
/// function throws Error(output) where the file system refuses.
class LockFile {
 public:
  /// Opens `path`, makes it where it is missing.
  explicit LockFile(const std::filesystem::path& path);
  ~LockFile();
  LockFile(const LockFile&) = delete;
  LockFile& operator=(const LockFile&) = delete;

  /// Takes `byte` for this object alone; false where another holds it. Never blocks.
  bool try_lock(uint64_t byte);
  /// Takes `byte` together with others that share it; false where one holds it alone. Turns a lock
  /// of this object's own into a shared one.
  bool try_share(uint64_t byte);
  void unlock(uint64_t byte);

  /// `count` bytes of the file's contents from `first`; 0 beyond its end.
  std::string read(uint64_t first, size_t count) const;
  void write(uint64_t first, const std::string& bytes);
  void clear();

  /// True once the file's name is gone from its folder.
  bool is_removed() const;

 private:
  bool set_lock(uint64_t byte, int type);
  [[noreturn]] void fail(const std::string& what) const;

  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace relume
