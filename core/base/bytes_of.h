#pragma once

#include <cstdint>
#include <vector>

namespace relume {

/// What vectors hold, in bytes, room to grow included; not what their elements hold elsewhere.
template <class... T>
uint64_t bytes_of(const std::vector<T>&... vectors) {
  return (uint64_t{0} + ... + (vectors.capacity() * sizeof(T)));
}

}  // namespace relume
