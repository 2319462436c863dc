#include "viewer/commands/process_memory.h"

#include <malloc.h>
#include <sys/resource.h>

#include <fstream>
#include <string>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define RELUME_SANITIZER_HEAP
/// Of the sanitizers, whose header Debian's GCC does not bring.
extern "C" size_t __sanitizer_get_current_allocated_bytes();
#endif

namespace relume {

uint64_t peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<uint64_t>(usage.ru_maxrss) * 1024;
}

uint64_t allocated_bytes() {
#ifdef RELUME_SANITIZER_HEAP
  return __sanitizer_get_current_allocated_bytes();  // glibc's own heap is not used
#elif defined(__GLIBC__) && __GLIBC_PREREQ(2, 33)
  const auto info = mallinfo2();
  return info.uordblks + info.hblkhd;
#else
  std::ifstream file("/proc/self/status");
  for (std::string word; file >> word;) {
    uint64_t kilobytes = 0;
    if (word == "VmRSS:" && file >> kilobytes) return kilobytes * 1024;
  }
  return 0;
#endif
}

}  // namespace relume
