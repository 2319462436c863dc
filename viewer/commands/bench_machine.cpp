#include "viewer/commands/bench_machine.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <limits>
#include <vector>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/image/image.h"
#include "viewer/commands/bench_time.h"

namespace relume {
namespace {

/// Slots of each type in the whole cache.
std::vector<uint64_t> count_slots(const RelightCache& cache) {
  std::vector<uint64_t> slots(cache.info().types.size());
  for (const PackedTile& tile : cache.tiles()) {
    for (int b = 0; b < tile.block_count; ++b) {
      const PackedBlock block = cache.block(tile, b);
      for (size_t t = 0; t < slots.size(); ++t) slots[t] += block.slots[t];
    }
  }
  return slots;
}

/// Some sum over the bytes of a tile's blocks: what frames without shadows need of it.
uint64_t read_tile(const PackedTile& tile) {
  const auto* first = reinterpret_cast<const uint64_t*>(tile.words);
  const auto* last = reinterpret_cast<const uint64_t*>(tile.coverage);
  uint64_t sum = 0;
  for (const uint64_t* p = first; p + 8 <= last; p += 8) {
    sum += (p[0] ^ p[1]) + (p[2] ^ p[3]) + (p[4] ^ p[5]) + (p[6] ^ p[7]);
  }
  return sum;
}

}  // namespace

double measure_clock_hz() {
  // Short and often: one turn runs undisturbed where others want the core, too.
  constexpr int64_t additions = 1'000'000;
  const double ms = least_ms(100, [] {
    uint64_t sum = 1;
    uint64_t addend = 3;
    // Opaque to the compiler, so that each addition is one instruction that waits for the last.
    for (int64_t i = 0; i < additions; i += 4) {
      sum += addend;
      asm volatile("" : "+r"(sum), "+r"(addend));
      sum += addend;
      asm volatile("" : "+r"(sum), "+r"(addend));
      sum += addend;
      asm volatile("" : "+r"(sum), "+r"(addend));
      sum += addend;
      asm volatile("" : "+r"(sum), "+r"(addend));
    }
  });
  return static_cast<double>(additions) / (ms * 1e-3);
}

double read_cache_ms(const RelightCache& cache, int repeats) {
  std::atomic<uint64_t> sink{0};
  return least_ms(repeats, [&] {
    parallel_for(cache.tiles().size(), 8, [&](size_t begin, size_t end) {
      uint64_t sum = 0;
      for (size_t t = begin; t < end; ++t) sum += read_tile(cache.tiles()[t]);
      sink += sum;
    });
  });
}

double read_write_ms(const RelightCache& cache, int layers, int repeats) {
  const std::span<const PackedTile> tiles = cache.tiles();
  std::vector<size_t> first{0};
  for (const PackedTile& tile : tiles) {
    first.push_back(first.back() + size_t{3} * block_lanes * tile.block_count);
  }
  std::vector<std::vector<float>> sums(layers, std::vector<float>(first.back()));
  Image frame(cache.info().width, cache.info().height);
  const auto copy = [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      const PackedTile& tile = tiles[t];
      if (tile.block_count == 0) continue;
      const auto value = static_cast<float>(read_tile(tile));
      for (auto& layer : sums) std::fill_n(&layer[first[t]], first[t + 1] - first[t], value);
      for (int y = tile.y0; y < tile.y0 + tile.height; ++y) {
        std::fill_n(frame.at(tile.x0, y), 3 * tile.width, value);
      }
    }
  };
  return least_ms(repeats, [&] { parallel_for(tiles.size(), 8, copy); });
}

MemoryFloor measure_memory_floor(const RelightCache& cache, int repeats) {
  return {read_cache_ms(cache, repeats),
          {{1, read_write_ms(cache, 1, repeats)}, {4, read_write_ms(cache, 4, repeats)}}};
}

PortCycles::PortCycles(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string set;
  std::string shader;
  std::string format;
  int kind = 0;
  int lights = 0;
  double cycles = 0;
  if (!std::getline(file, model_)) {
    throw input_error(path.string(), "cannot be read", "make it with tests/bench/port_cycles.py");
  }
  while (file >> set >> shader >> format >> kind >> lights >> cycles) {
    slot_cycles_[{set, shader, format, kind, lights}] = cycles;
  }
  if (!file.eof()) {
    throw input_error(path.string(), "is not a list of kernels",
                      "make it with tests/bench/port_cycles.py");
  }
}

double PortCycles::frame_cycles(const RelightCache& cache, const std::string& instruction_set,
                                int kind, int lights) const {
  const std::vector<uint64_t> slots = count_slots(cache);
  const std::string format(label_of(cache_format_labels, cache.info().format));
  double sum = 0;
  for (size_t t = 0; t < slots.size(); ++t) {
    const std::string shader(cache.info().types[t].shader->name);
    const auto found = slot_cycles_.find({instruction_set, shader, format, kind, lights});
    if (found == slot_cycles_.end()) return std::numeric_limits<double>::quiet_NaN();
    sum += static_cast<double>(slots[t]) * found->second;
  }
  return sum;
}

}  // namespace relume
