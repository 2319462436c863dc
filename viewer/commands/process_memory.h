#pragma once

#include <cstdint>

namespace relume {

/// Largest resident size of this process so far, in bytes (getrusage).
uint64_t peak_memory_bytes();

/// Bytes that the process holds from its allocator now; its resident size where the C library does
/// not tell (not glibc). Mapped files are not part of it.
uint64_t allocated_bytes();

}  // namespace relume
