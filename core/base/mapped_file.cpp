#include "core/base/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string>
#include <utility>

#include "core/base/error.h"

namespace relume {
namespace {

/// What a signal handler may look up: which file is mapped where. A slot is free while `begin` is
/// null and taken by whoever puts its address there; the name is complete once `size` is not 0.
struct Mapping {
  std::atomic<const std::byte*> begin = nullptr;
  std::atomic<size_t> size = 0;
  std::array<char, 240> name = {};
};
static_assert(std::atomic<const std::byte*>::is_always_lock_free);

/// Mappings beyond these are read as well; a fault in one is not told by name.
std::array<Mapping, 256> mappings;

void remember(const std::byte* begin, size_t size, const std::string& name) {
  for (Mapping& mapping : mappings) {
    const std::byte* nobody = nullptr;
    if (!mapping.begin.compare_exchange_strong(nobody, begin)) continue;
    // The end of a long path tells more than its beginning.
    const size_t length = std::min(name.size(), mapping.name.size() - 1);
    name.copy(mapping.name.data(), length, name.size() - length);
    mapping.name[length] = 0;
    mapping.size = size;
    return;
  }
}

void forget(const std::byte* begin) {
  for (Mapping& mapping : mappings) {
    if (mapping.begin != begin) continue;
    mapping.size = 0;
    mapping.begin = nullptr;
    return;
  }
}

void write_error(const char* text) {
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text, std::strlen(text));
}

/// Only calls that are safe in a signal handler.
void on_bus_error(int signal, siginfo_t* info, void*) {
  const auto* address = static_cast<const std::byte*>(info->si_addr);
  for (const Mapping& mapping : mappings) {
    const std::byte* begin = mapping.begin;
    if (begin == nullptr || address < begin || address >= begin + mapping.size) continue;
    write_error("relume: ");
    write_error(mapping.name.data());
    write_error(
        ": was shortened by another program while it was open, or cannot be read from its "
        "disk; make it again\n");
    _exit(static_cast<int>(ErrorKind::input));
  }
  std::signal(signal, SIG_DFL);  // the fault comes again and is what it was
}

}  // namespace

MappedFile::MappedFile(const std::filesystem::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    throw input_error(path.string(), std::string("cannot open: ") + std::strerror(errno),
                      "check the path");
  }
  struct stat status {};
  if (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    close(descriptor);
    throw input_error(path.string(), "is not a regular file", "give a file");
  }
  size_ = static_cast<size_t>(status.st_size);
  if (size_ > 0) {
    void* address = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (address == MAP_FAILED) {
      close(descriptor);
      throw input_error(path.string(), std::string("cannot map: ") + std::strerror(errno),
                        "free some memory");
    }
    data_ = static_cast<const std::byte*>(address);
    remember(data_, size_, path.string());
  }
  close(descriptor);
}

MappedFile::~MappedFile() {
  if (data_ == nullptr) return;
  forget(data_);
  munmap(const_cast<std::byte*>(data_), size_);
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

void install_mapping_guard() {
  struct sigaction action {};
  action.sa_sigaction = on_bus_error;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGBUS, &action, nullptr);
}

}  // namespace relume
