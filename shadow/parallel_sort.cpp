#include "shadow/parallel_sort.h"

#include <algorithm>
#include <array>

#include "core/base/parallel.h"

namespace relume {
namespace {

constexpr int digit_bits = 11;
constexpr uint32_t digits = 1u << digit_bits;
/// Pieces that are counted and moved by themselves; their number never depends on the threads.
constexpr size_t parts = 32;

using Histogram = std::array<uint32_t, digits>;

void sort_digit(const std::vector<KeyedIndex>& from, std::vector<KeyedIndex>& to, int shift,
                std::vector<Histogram>& counts) {
  const auto begin_of = [&](size_t part) { return from.size() * part / parts; };
  const auto digit_of = [shift](uint32_t key) { return key >> shift & (digits - 1); };
  parallel_for(parts, 1, [&](size_t first, size_t last) {
    for (size_t part = first; part < last; ++part) {
      counts[part].fill(0);
      for (size_t i = begin_of(part); i < begin_of(part + 1); ++i) {
        ++counts[part][digit_of(from[i].key)];
      }
    }
  });
  uint32_t start = 0;
  for (uint32_t digit = 0; digit < digits; ++digit) {
    for (Histogram& count : counts) {
      const uint32_t size = count[digit];
      count[digit] = start;
      start += size;
    }
  }
  parallel_for(parts, 1, [&](size_t first, size_t last) {
    for (size_t part = first; part < last; ++part) {
      for (size_t i = begin_of(part); i < begin_of(part + 1); ++i) {
        to[counts[part][digit_of(from[i].key)]++] = from[i];
      }
    }
  });
}

}  // namespace

void sort_by_key(std::vector<KeyedIndex>& items, std::vector<KeyedIndex>& scratch) {
  scratch.resize(items.size());
  std::vector<Histogram> counts(parts);
  for (int shift = 0; shift < 32; shift += digit_bits) {
    sort_digit(items, scratch, shift, counts);
    items.swap(scratch);
  }
}

}  // namespace relume
