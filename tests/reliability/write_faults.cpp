// A library to preload (LD_PRELOAD): counts the calls by which a program changes files, and kills
// the program at one of them or makes calls fail. RELUME_FAULT is "MODE NUMBER", the number of a
// call from 1:
//   kill N   SIGKILL before call N
//   half N   SIGKILL after half of the bytes of write N; after call N where it is no write
//   full N   from call N on a full disk: creating and writing fail with ENOSPC
//   fail N   call N alone fails with EIO
// RELUME_FAULT_LOG names a file that takes one line a call: its name, and for a rename "unsynced"
// where bytes of the renamed file were not flushed to the disk before.

#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <set>
#include <string>

namespace {

struct Fault {
  std::string mode;
  long number = 0;
  int log = -1;

  Fault() {
    if (const char* text = std::getenv("RELUME_FAULT")) {
      const std::string words = text;
      mode = words.substr(0, words.find(' '));
      number = std::atol(words.c_str() + mode.size());
    }
    if (const char* path = std::getenv("RELUME_FAULT_LOG")) {
      log = static_cast<int>(
          syscall(SYS_openat, AT_FDCWD, path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
    }
  }
};

enum class Action { go_on, fail, half_then_kill, after_then_kill };

std::mutex mutex;
long call_count = 0;
std::set<std::pair<dev_t, ino_t>> unsynced;

const Fault& fault() {
  static const Fault instance;
  return instance;
}

void write_log(const char* name) {
  if (fault().log < 0) return;
  const std::string line = std::string(name) + "\n";
  syscall(SYS_write, fault().log, line.data(), line.size());
}

/// Counts a call and says what becomes of it. `takes_space`: fails on a full disk.
Action count_call(const char* name, bool is_write, bool takes_space) {
  const std::lock_guard lock(mutex);
  ++call_count;
  write_log(name);
  const Fault& wanted = fault();
  if (wanted.mode == "full" && call_count >= wanted.number && takes_space) {
    errno = ENOSPC;
    return Action::fail;
  }
  if (call_count != wanted.number) return Action::go_on;
  if (wanted.mode == "kill") kill(getpid(), SIGKILL);
  if (wanted.mode == "half") return is_write ? Action::half_then_kill : Action::after_then_kill;
  if (wanted.mode == "fail") {
    errno = EIO;
    return Action::fail;
  }
  return Action::go_on;
}

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

/// Does call() as `action` says.
template <class Call>
auto perform(Action action, const Call& call) -> decltype(call()) {
  if (action == Action::fail) return -1;
  const auto result = call();
  if (action == Action::after_then_kill) kill(getpid(), SIGKILL);
  return result;
}

bool is_file(int descriptor, struct stat& status) {
  return fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
}

/// Does write(size) as the fault says; the file has bytes that are not on the disk from then on.
template <class Write>
ssize_t perform_write(const char* name, int descriptor, size_t size, const Write& write) {
  struct stat status {};
  if (!is_file(descriptor, status)) return write(size);
  const Action action = count_call(name, true, true);
  if (action == Action::fail) return -1;
  if (action == Action::half_then_kill) {
    write(size / 2);
    kill(getpid(), SIGKILL);
  }
  const std::lock_guard lock(mutex);
  unsynced.insert({status.st_dev, status.st_ino});
  return write(size);
}

int open_file(const char* symbol, const char* path, int flags, mode_t mode) {
  const auto real = next<int(const char*, int, ...)>(symbol);
  if ((flags & O_CREAT) == 0) return real(path, flags, mode);
  return perform(count_call("create", false, true), [&] { return real(path, flags, mode); });
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(arguments, mode_t) : 0;
  va_end(arguments);
  return open_file("open", path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(arguments, mode_t) : 0;
  va_end(arguments);
  return open_file("open64", path, flags, mode);
}

ssize_t write(int descriptor, const void* bytes, size_t size) {
  const auto real = next<ssize_t(int, const void*, size_t)>("write");
  return perform_write("write", descriptor, size,
                       [&](size_t part) { return real(descriptor, bytes, part); });
}

ssize_t writev(int descriptor, const iovec* parts, int count) {
  const auto real = next<ssize_t(int, const iovec*, int)>("writev");
  return perform_write("writev", descriptor, static_cast<size_t>(count), [&](size_t part) {
    return real(descriptor, parts, static_cast<int>(part));
  });
}

ssize_t pwrite(int descriptor, const void* bytes, size_t size, off_t offset) {
  const auto real = next<ssize_t(int, const void*, size_t, off_t)>("pwrite");
  return perform_write("pwrite", descriptor, size,
                       [&](size_t part) { return real(descriptor, bytes, part, offset); });
}

int fsync(int descriptor) {
  const auto real = next<int(int)>("fsync");
  struct stat status {};
  const bool known = fstat(descriptor, &status) == 0;
  const int result =
      perform(count_call(known && S_ISDIR(status.st_mode) ? "fsync-folder" : "fsync", false, false),
              [&] { return real(descriptor); });
  const std::lock_guard lock(mutex);
  if (result == 0 && known) unsynced.erase({status.st_dev, status.st_ino});
  return result;
}

int rename(const char* from, const char* to) noexcept {
  const auto real = next<int(const char*, const char*)>("rename");
  struct stat status {};
  bool is_unsynced = false;
  if (stat(from, &status) == 0) {
    const std::lock_guard lock(mutex);
    is_unsynced = unsynced.contains({status.st_dev, status.st_ino});
  }
  return perform(count_call(is_unsynced ? "rename unsynced" : "rename", false, false),
                 [&] { return real(from, to); });
}

int unlink(const char* path) noexcept {
  const auto real = next<int(const char*)>("unlink");
  return perform(count_call("unlink", false, false), [&] { return real(path); });
}

}  // extern "C"
