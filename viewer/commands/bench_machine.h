#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <tuple>

#include "core/samples/relight_cache.h"
#include "core/scene/light.h"

namespace relume {

/// Cycles per second that this core runs at now: a chain of dependent additions, one cycle each.
double measure_clock_hz();

/// Least time in milliseconds of `repeats` passes over the blocks of the cache's tiles with all
/// threads: what memory alone would cost a frame without shadows.
double read_cache_ms(const RelightCache& cache, int repeats);

/// The same with writing what a frame must leave: `layers` layers, three floats for each lane of
/// the cache's blocks, and the pixels of the frame in tiles that have records.
double read_write_ms(const RelightCache& cache, int layers, int repeats);

/// What memory costs a frame, measured in this process.
struct MemoryFloor {
  double read_ms = 0;                     ///< read_cache_ms
  std::map<int, double> read_write_ms{};  ///< by lights that move: 1 and 4
};
MemoryFloor measure_memory_floor(const RelightCache& cache, int repeats);

/// How many cycles a kernel needs for one slot (16 records) when nothing but the number of
/// execution ports limits it, as tests/bench/port_cycles.py finds out with llvm-mca.
class PortCycles {
 public:
  /// Knows nothing.
  PortCycles() = default;
  /// Reads lines of "instruction-set shader format light-kind lights cycles" after a line that
  /// names the processor models. Throws Error(input).
  explicit PortCycles(const std::filesystem::path& path);

  /// Processor models that stand in for this one, or "no llvm-mca".
  const std::string& model() const { return model_; }
  /// Cycles of one core for all slots of the cache, under `lights` lights of kind `kind` in one
  /// pass; NaN when a kernel is missing.
  double frame_cycles(const RelightCache& cache, const std::string& instruction_set, int kind,
                      int lights) const;

 private:
  std::string model_ = "no llvm-mca";
  std::map<std::tuple<std::string, std::string, std::string, int, int>, double> slot_cycles_;
};

}  // namespace relume
