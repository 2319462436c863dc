#include "core/base/lock_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/base/error.h"

namespace relume {

LockFile::LockFile(const std::filesystem::path& path) : path_(path) {
  descriptor_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor_ < 0) fail("open");
}

LockFile::~LockFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

void LockFile::fail(const std::string& what) const {
  throw output_error(path_.string(), "cannot " + what + ": " + std::strerror(errno),
                     "choose a folder that can be written and whose file system has locks");
}

bool LockFile::set_lock(uint64_t byte, int type) {
  struct flock lock {};
  lock.l_type = static_cast<short>(type);
  lock.l_whence = SEEK_SET;
  lock.l_start = static_cast<off_t>(byte);
  lock.l_len = 1;
  // Locks of the open file, not of the process: two objects in one process exclude each other too.
  while (fcntl(descriptor_, F_OFD_SETLK, &lock) != 0) {
    if (errno == EAGAIN || errno == EACCES) return false;
    if (errno != EINTR) fail("lock");
  }
  return true;
}

bool LockFile::try_lock(uint64_t byte) {
  return set_lock(byte, F_WRLCK);
}

bool LockFile::try_share(uint64_t byte) {
  return set_lock(byte, F_RDLCK);
}

void LockFile::unlock(uint64_t byte) {
  set_lock(byte, F_UNLCK);
}

std::string LockFile::read(uint64_t first, size_t count) const {
  std::string bytes(count, '\0');
  size_t done = 0;
  while (done < count) {
    const ssize_t got =
        pread(descriptor_, bytes.data() + done, count - done, static_cast<off_t>(first + done));
    if (got == 0) break;
    if (got < 0 && errno != EINTR) fail("read");
    if (got > 0) done += static_cast<size_t>(got);
  }
  return bytes;
}

void LockFile::write(uint64_t first, const std::string& bytes) {
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t put = pwrite(descriptor_, bytes.data() + done, bytes.size() - done,
                               static_cast<off_t>(first + done));
    if (put < 0 && errno != EINTR) fail("write");
    if (put > 0) done += static_cast<size_t>(put);
  }
}

void LockFile::clear() {
  if (ftruncate(descriptor_, 0) != 0) fail("clear");
}

bool LockFile::is_removed() const {
  struct stat status {};
  return fstat(descriptor_, &status) == 0 && status.st_nlink == 0;
}

}  // namespace relume
