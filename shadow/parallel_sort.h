#pragma once

#include <cstdint>
#include <vector>

namespace relume {

/// A key and what it belongs to.
struct KeyedIndex {
  uint32_t key;
  uint32_t index;
};

/// Sorts by key, stably, in parallel. `scratch` is resized; give the same one again to allocate
/// nothing. Takes time linear in the count.
void sort_by_key(std::vector<KeyedIndex>& items, std::vector<KeyedIndex>& scratch);

}  // namespace relume
