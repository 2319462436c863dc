#pragma once

#include <cstdint>

#include "core/samples/relight_cache.h"
#include "core/shade/kernel_light.h"
#include "core/simd/instruction_set.h"

namespace relume {

inline constexpr int max_kernel_lights = 4;  ///< that one pass over the records can shade

/// Floats of a block's sums: 16 reds, 16 greens, 16 blues.
inline constexpr int block_floats = 48;

/// Floats of a tile's sums, block after block.
inline constexpr int tile_floats = max_tile_blocks * block_floats;

/// One block: 16 pixels, one per lane (see PackedBlock).
struct KernelBlock {
  const uint32_t* words;
  const float* frame;       ///< of packed formats
  const uint16_t* slots;    ///< per type
  const float* visibility;  ///< 16 per slot, in slot order, or null: all 1. Needs one light
};

/// Blocks of a tile and the lights that shade them.
struct KernelTile {
  const KernelBlock* blocks;  ///< all have a visibility or none has
  int block_count;            ///< 1 to max_tile_blocks
  CacheFormat format;
  const int* shaders;  ///< per type: index into the shader list
  int type_count;
  const ViewAxes* axes;
  const KernelLight* lights;  ///< of one kind
  int light_count;            ///< 1 to max_kernel_lights
  /// Out: the blocks' sums under the first light; those under light i lie i * tile_floats further.
  float* sums;
};

/// A run of slots of one type, in any format.
struct EncodedSlots {
  CacheFormat format;
  int shader;  ///< index into the shader list
  const uint32_t* words;
  const float* frame;    ///< of packed formats
  float bias;            ///< of the type in this block, packed formats
  const ViewAxes* axes;  ///< of packed formats
  int count;
};

struct BlockKernels {
  void (*shade_blocks)(const KernelTile&);
  /// Writes slots as the exact format has them: per slot 16 weights, 1 or 0 from packed formats,
  /// whose colours hold the weights, then 16 floats for each component.
  void (*decode_slots)(const EncodedSlots&, float* out);
  /// sums[b] += weight * layer[b], `weight` per channel, over `blocks` blocks of block_floats.
  void (*add_layer)(const float* layer, const float* weight, int blocks, float* sums);
  /// Replaces what is not finite by 0; returns how many values it replaced.
  int (*make_finite)(int blocks, float* sums);
  /// Copies to a layer, aligned to 64 bytes, that is not read again soon; finish_streams() before
  /// another thread reads it.
  void (*stream_layer)(const float* sums, int blocks, float* layer);
  void (*finish_streams)();
  /// Writes the pixels of one block's sums as RGB: lane i of `lanes` to out[offsets[pixels[i]]].
  void (*write_pixels)(const float* sums, const uint8_t* pixels, int lanes, const int* offsets,
                       float* out);
};

/// The block kernels of `set` (already chosen, not automatic).
BlockKernels block_kernels(InstructionSet set);

namespace scalar {
BlockKernels make_block_kernels();
}
namespace sse42 {
BlockKernels make_block_kernels();
}
namespace avx2 {
BlockKernels make_block_kernels();
}
namespace avx512 {
BlockKernels make_block_kernels();
}

}  // namespace relume
