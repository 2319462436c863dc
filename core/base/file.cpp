#include "core/base/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <random>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/base/mapped_file.h"

namespace relume {
namespace {

std::string system_message() {
  return std::strerror(errno);
}

void write_fully(int descriptor, std::span<const std::byte> bytes, uint64_t offset,
                 const std::filesystem::path& path) {
  while (!bytes.empty()) {
    const ssize_t written =
        pwrite(descriptor, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0) {
      if (errno == EINTR) continue;
      throw output_error(path.string(), "cannot write: " + system_message(),
                         "free some space or choose another folder");
    }
    bytes = bytes.subspan(static_cast<size_t>(written));
    offset += static_cast<uint64_t>(written);
  }
}

/// What stands between a file's name and the 16 hexadecimal digits that end its temporary's.
constexpr std::string_view temporary_mark = ".relume-tmp-";

std::filesystem::path folder_of(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : ".";
}

/// A temporary's name that nobody else has: 64 random bits.
std::filesystem::path make_temporary_name(const std::filesystem::path& path) {
  thread_local std::random_device device;
  return path.string() + fmt::format("{}{:08x}{:08x}", temporary_mark, device() & 0xffffffffu,
                                     device() & 0xffffffffu);
}

bool is_temporary_name(std::string_view name) {
  constexpr size_t digits = 16;
  if (name.size() <= temporary_mark.size() + digits) return false;
  const std::string_view end = name.substr(name.size() - digits - temporary_mark.size());
  return end.starts_with(temporary_mark) &&
         end.find_first_not_of("0123456789abcdef", temporary_mark.size()) == std::string_view::npos;
}

/// Removes the temporary unless a living writer holds its lock.
void remove_if_abandoned(const std::filesystem::path& temporary) {
  const int descriptor = open(temporary.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC);
  if (descriptor < 0) return;
  if (flock(descriptor, LOCK_EX | LOCK_NB) == 0) unlink(temporary.c_str());
  close(descriptor);
}

/// Removes what writers that were killed left in `folder`; once in a process, for each folder.
void remove_abandoned_temporaries(const std::filesystem::path& folder) {
  static std::mutex mutex;
  static std::set<std::filesystem::path> done;
  std::error_code failure;
  const std::filesystem::path whole = std::filesystem::absolute(folder, failure);
  const std::lock_guard lock(mutex);
  if (!done.insert(whole).second) return;
  std::filesystem::directory_iterator entry(folder, failure);
  for (; !failure && entry != std::filesystem::directory_iterator(); entry.increment(failure)) {
    if (is_temporary_name(entry->path().filename().string())) remove_if_abandoned(entry->path());
  }
}

/// Opens a new file that is locked while its writer lives. -1 and errno where that fails.
int open_locked(const std::filesystem::path& temporary) {
  const int descriptor = open(temporary.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (descriptor < 0) return -1;
  // Where the file system knows no locks nobody can take one, and nothing is removed.
  flock(descriptor, LOCK_EX | LOCK_NB);
  struct stat status {};
  if (fstat(descriptor, &status) == 0 && status.st_nlink > 0) return descriptor;
  // Another process took it for abandoned before the lock was on it.
  close(descriptor);
  errno = EEXIST;
  return -1;
}

}  // namespace

AtomicFile::AtomicFile(const std::filesystem::path& path) : path_(path) {
  remove_abandoned_temporaries(folder_of(path));
  do {
    temporary_ = make_temporary_name(path);
    descriptor_ = open_locked(temporary_);
  } while (descriptor_ < 0 && errno == EEXIST);
  if (descriptor_ < 0) {
    throw output_error(path.string(), "cannot create: " + system_message(),
                       "check that the folder exists and is writable");
  }
}

AtomicFile::~AtomicFile() {
  if (descriptor_ < 0) return;
  close(descriptor_);
  unlink(temporary_.c_str());
}

void AtomicFile::append(std::span<const std::byte> bytes) {
  write_fully(descriptor_, bytes, size_, path_);
  size_ += bytes.size();
}

void AtomicFile::write_at(uint64_t offset, std::span<const std::byte> bytes) {
  write_fully(descriptor_, bytes, offset, path_);
}

void AtomicFile::commit() {
  if (fsync(descriptor_) != 0) {
    throw output_error(path_.string(), "cannot flush: " + system_message(), "check the disk");
  }
  // Closed behind the rename: until then the lock keeps the temporary.
  if (rename(temporary_.c_str(), path_.c_str()) != 0) {
    throw output_error(path_.string(), "cannot rename into place: " + system_message(),
                       "check that the target is not a folder");
  }
  close(descriptor_);
  descriptor_ = -1;
  const int folder_descriptor = open(folder_of(path_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder_descriptor >= 0) {
    fsync(folder_descriptor);
    close(folder_descriptor);
  }
}

void write_file_atomic(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  AtomicFile file(path);
  file.append(bytes);
  file.commit();
}

void write_file_atomic(const std::filesystem::path& path, const std::string& text) {
  write_file_atomic(path, std::as_bytes(std::span(text)));
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw output_error(folder.string(), error.message(), "choose another folder");
}

std::string read_text_file(const std::filesystem::path& path, uint64_t max_bytes) {
  const MappedFile file(path);
  const std::span<const std::byte> bytes = file.bytes();
  if (bytes.size() > max_bytes) {
    throw limit_error(path.string(), fmt::format("{} bytes is too large", bytes.size()),
                      fmt::format("the limit is {} bytes", max_bytes));
  }
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace relume
