#pragma once

#include <cstdint>

#include "core/shade/kernel_light.h"
#include "core/simd/instruction_set.h"

namespace relume {

inline constexpr int max_kernel_lights = 4;  ///< that one pass over the records can shade

inline constexpr int max_kernel_blocks = 16;  ///< that one call shades: a tile's

/// One block: 16 pixels, one per lane (see PackedBlock).
struct KernelBlock {
  const float* data;
  const uint16_t* slots;    ///< per type
  const float* visibility;  ///< 16 per slot, in slot order, or null: all 1. Needs a single light
  const uint8_t* pixels;    ///< per lane: index into KernelTile::rgbx, in pixels
  int lanes;                ///< in use, 1..16
};

/// Blocks of a tile and the lights that shade them.
struct KernelTile {
  const KernelBlock* blocks;  ///< all have a visibility or none has
  int block_count;            ///< 1 to max_kernel_blocks
  const int* shaders;         ///< per type: index into the shader list
  int type_count;
  float eye[3];
  const KernelLight* lights;  ///< of one kind
  int light_count;            ///< 1 to max_kernel_lights
  /// Out, per light: the sums of the blocks' pixels as four floats, RGB and 0.
  float* rgbx[max_kernel_lights];
};

using ShadeBlocks = void (*)(const KernelTile&);

/// The block kernel of `set` (already chosen, not automatic).
ShadeBlocks block_kernel(InstructionSet set);

namespace scalar {
void shade_blocks(const KernelTile&);
}
namespace sse42 {
void shade_blocks(const KernelTile&);
}
namespace avx2 {
void shade_blocks(const KernelTile&);
}
namespace avx512 {
void shade_blocks(const KernelTile&);
}

}  // namespace relume
