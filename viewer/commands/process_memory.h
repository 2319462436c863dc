#pragma once

#include <cstdint>

namespace relume {

/// Largest resident size of this process so far, in bytes (getrusage).
uint64_t peak_memory_bytes();

}  // namespace relume
