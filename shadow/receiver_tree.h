#pragma once

#include <array>
#include <vector>

#include "shadow/learned_receivers.h"
#include "shadow/light_views.h"
#include "shadow/parallel_sort.h"

namespace relume {

/// A part of the light's picture and the receivers in it. Bounds are those of their footprints.
struct ReceiverNode {
  float u_low = 0;
  float u_high = 0;
  float v_low = 0;
  float v_high = 0;
  float z_high = 0;    ///< nothing farther is in front of any of them
  float size_low = 0;  ///< size of the smallest footprint
  uint32_t first_child = 0;
  uint32_t child_count = 0;  ///< 0 = leaf
  uint32_t leaf = 0;         ///< of a leaf
};

struct ReceiverLeaf {
  uint32_t first_item = 0;  ///< of ReceiverTree::items
  uint32_t item_count = 0;
  uint32_t first_block = 0;
  uint32_t block_count = 0;
};

/// Receivers of all views, sorted along a curve that fills each view's picture and by size, in
/// blocks of 16; above them quadtrees. Where receivers are dense, nodes are small.
struct ReceiverTree {
  std::vector<KeyedIndex> items;  ///< index into the learned receivers
  std::vector<ReceiverLeaf> leaves;
  std::vector<ReceiverNode> nodes;  ///< children stand behind their parent, side by side
  struct View {
    uint32_t root = 0;
    bool is_used = false;
    float w_low = 0;  ///< of the receivers' means
  };
  std::array<View, max_light_views> views;
  std::vector<float> blocks;  ///< coverage_block_floats each
  std::vector<float> bounds[6];
  uint32_t block_count = 0;
  bool has_near = false;  ///< receivers are ReceiverState::near

  uint64_t memory_bytes() const {
    uint64_t bytes = bytes_of(items, leaves, nodes, blocks);
    for (const auto& part : bounds) bytes += bytes_of(part);
    return bytes;
  }
  CoverageBounds bounds_of(uint32_t block) {
    return {&bounds[0][block], &bounds[1][block], &bounds[2][block],
            &bounds[3][block], &bounds[4][block], &bounds[5][block]};
  }
};

/// What becomes of a receiver under a light.
enum class ReceiverState : uint8_t {
  unlit,    ///< the light cannot light it: visibility 1, no work
  hidden,   ///< by its own surface, which turns away though its normal does not, or its body: 0
  covered,  ///< in the tree
  near,     ///< so near that the light sees its footprint from all sides: rays
};

/// A footprint of more than this part of its distance from the light is near.
inline constexpr float near_footprint = 0.25f;

/// Makes `tree` anew for the receivers in a share of the pixels that the light may light, and fills
/// in their `states`. Deterministic for any thread count. `scratch`: give the same one again to
/// allocate nothing.
void build_receiver_tree(const LearnedReceivers& receivers, const LightViews& lights,
                         PixelShare share, const CoverageKernels& kernels, ReceiverTree& tree,
                         std::vector<ReceiverState>& states, std::vector<KeyedIndex>& scratch);

/// Takes blocks that went dark out of the bounds, so that nothing is drawn onto them any more.
void bound_lit_receivers(ReceiverTree& tree);

}  // namespace relume
