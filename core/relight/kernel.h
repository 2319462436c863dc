#pragma once

#include <cstdint>

#include "core/samples/record_layout.h"
#include "core/shade/kernel_light.h"
#include "core/simd/instruction_set.h"

namespace relume {

inline constexpr int max_kernel_lights = 4;  ///< that one pass over the records can shade

inline constexpr int max_kernel_blocks = 16;  ///< that one call shades: a tile's

/// One block: 16 pixels, one per lane (see PackedBlock).
struct KernelBlock {
  const uint32_t* words;
  const float* frame;       ///< of packed formats
  const uint16_t* slots;    ///< per type
  const float* visibility;  ///< 16 per slot, in slot order, or null: all 1. Needs one light
  const uint8_t* pixels;    ///< per lane: index into KernelTile::rgbx, in pixels
  int lanes;                ///< in use, 1..16
};

/// Blocks of a tile and the lights that shade them.
struct KernelTile {
  const KernelBlock* blocks;  ///< all have a visibility or none has
  int block_count;            ///< 1 to max_kernel_blocks
  CacheFormat format;
  const int* shaders;  ///< per type: index into the shader list
  int type_count;
  const ViewAxes* axes;
  const KernelLight* lights;  ///< of one kind
  int light_count;            ///< 1 to max_kernel_lights
  /// Out, per light: the sums of the blocks' pixels as four floats, RGB and 0.
  float* rgbx[max_kernel_lights];
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
