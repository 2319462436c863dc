#pragma once

#include <vector>

#include "core/relight/kernel.h"
#include "core/samples/relight_cache.h"

namespace relume {

/// Shows blocks of any format as the exact format has them. Thread-safe.
class BlockDecoder {
 public:
  /// `cache` must outlive the decoder. `set` as in RelightParams.
  BlockDecoder(const RelightCache& cache, InstructionSet set);

  /// The block's slots, type by type: per slot 16 weights, then 16 floats for each of the type's
  /// components. Where colours hold the weights, a weight is 1, or 0 where no record is. Points
  /// into the cache or into `scratch`.
  const float* floats(const PackedBlock& block, std::vector<float>& scratch) const;

  /// Per type: index into the shader list.
  const std::vector<int>& shaders() const { return shaders_; }

 private:
  const RelightCache& cache_;
  std::vector<int> shaders_;
  BlockKernels kernels_;
};

}  // namespace relume
