#include "shadow/receiver_tree.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace relume {
namespace {

constexpr uint32_t leaf_receivers = max_task_blocks * coverage_lanes;
constexpr uint32_t most_leaf_receivers = leaf_receivers;
constexpr int morton_bits = 26;
constexpr int size_bits = 2;
/// A key is the view, the place's upper bits, the size, and the place's lower bits: parts of the
/// picture are neighbours in it, and small parts hold footprints of one size.
constexpr int key_bits = morton_bits + size_bits;
constexpr int lower_bits = 8;

/// What a tile's receivers add up to.
struct TileSums {
  bool has_near = false;
  size_t covered = 0;
  std::array<ReceiverTree::View, max_light_views> views;
};

float squared_footprint_size(const CoverageReceiver& receiver) {
  const float* c = receiver.covariance;
  return 3 * (c[0] + c[3] + c[5]);
}

bool faces(const int16_t (&normal)[3], dvec3 direction) {
  return normal[0] * direction.x + normal[1] * direction.y + normal[2] * direction.z > 0;
}

ReceiverState find_state(const LearnedReceivers& receivers, const LightViews& lights, size_t i) {
  const CoverageReceiver& receiver = receivers.spots[i];
  const dvec3 p(receiver.position[0], receiver.position[1], receiver.position[2]);
  dvec3 to_light = lights.to_light;
  double squared_distance = std::numeric_limits<double>::infinity();
  if (!lights.is_parallel) {
    to_light = lights.position - p;
    squared_distance = glm::dot(to_light, to_light);
    if (!(squared_distance > 0)) return ReceiverState::near;
    if (lights.cos_outer > -1 &&
        glm::dot(to_light, lights.to_light) < lights.cos_outer * std::sqrt(squared_distance)) {
      return ReceiverState::unlit;
    }
  }
  if (receiver.margin > 0) {  // strands have no normals
    const bool is_facing = faces(receiver.normal, to_light);
    if (receiver.lit_from_behind == 0 && !is_facing) return ReceiverState::unlit;
    // Its own surface hides it, as it does from a ray that starts on the side of `normal`.
    if (is_facing != faces(receiver.plane, to_light)) return ReceiverState::hidden;
    if (!is_facing && receiver.has_back != 0) return ReceiverState::hidden;
  }
  constexpr double near = static_cast<double>(near_footprint);
  const bool is_near =
      static_cast<double>(squared_footprint_size(receiver)) > near * near * squared_distance;
  return is_near ? ReceiverState::near : ReceiverState::covered;
}

/// The bits of x, with a zero between each two.
uint32_t spread_bits(uint32_t x) {
  x &= 0xffff;
  x = (x | x << 8) & 0x00ff00ff;
  x = (x | x << 4) & 0x0f0f0f0f;
  x = (x | x << 2) & 0x33333333;
  return (x | x << 1) & 0x55555555;
}

/// Finds where receivers stand in the light's picture.
class ReceiverPlacer {
 public:
  ReceiverPlacer(const LearnedReceivers& receivers, const LightViews& lights)
      : receivers_(receivers), lights_(lights), to_unit_(0.5f / lights.extent) {
    float size = receivers.mean_size;
    for (float& least : squared_size_) {
      least = size * size;
      size *= 3;
    }
  }

  KeyedIndex place(size_t i, TileSums& sums) const {
    const CoverageReceiver& receiver = receivers_.spots[i];
    const vec3 p(receiver.position[0], receiver.position[1], receiver.position[2]);
    const size_t v = lights_.view_of(p);
    const ViewPoint at = view_point(lights_.views[v], p);
    ReceiverTree::View& view = sums.views[v];
    view.w_low = view.is_used ? std::min(view.w_low, at.w) : at.w;
    view.is_used = true;
    ++sums.covered;
    const float inverse = 1 / std::max(at.w, 1e-9f);
    const uint32_t code =
        spread_bits(step_of(at.x * inverse)) | spread_bits(step_of(at.y * inverse)) << 1;
    const float size = squared_footprint_size(receiver) * inverse * inverse;
    uint32_t size_class = 0;
    for (const float least : squared_size_) size_class += size >= least ? 1 : 0;
    const uint32_t lower = code & ((1u << lower_bits) - 1);
    const uint32_t upper =
        static_cast<uint32_t>(v) << (morton_bits - lower_bits) | code >> lower_bits;
    return {(upper << size_bits | size_class) << lower_bits | lower, static_cast<uint32_t>(i)};
  }

 private:
  static constexpr int size_steps = (1 << size_bits) - 1;

  /// Of a coordinate of the picture.
  uint32_t step_of(float u) const {
    constexpr float steps = static_cast<float>(1 << (morton_bits / 2)) - 1;
    return static_cast<uint32_t>(std::clamp(u * to_unit_ + 0.5f, 0.0f, 1.0f) * steps);
  }

  const LearnedReceivers& receivers_;
  const LightViews& lights_;
  float to_unit_;
  float squared_size_[size_steps];  ///< from which on a footprint is of the next class
};

/// Adds the node of items [begin, end), which agree in all bits from `shift` on, at `index`.
class TreeBuilder {
 public:
  explicit TreeBuilder(ReceiverTree& tree) : tree_(tree) {}

  void build(uint32_t index, uint32_t begin, uint32_t end, int shift) {
    if (end - begin <= leaf_receivers || (shift == 0 && end - begin <= most_leaf_receivers)) {
      add_leaf(index, begin, end);
      return;
    }
    struct Part {
      uint32_t begin, end;
    };
    std::vector<Part> parts;
    int below = shift;
    if (shift == 0) {  // all at one place
      for (uint32_t b = begin; b < end; b += most_leaf_receivers) {
        parts.push_back({b, std::min(end, b + most_leaf_receivers)});
      }
    } else {
      while (parts.size() < 2 && below > 0) {
        below -= 2;
        parts.clear();
        for (uint32_t b = begin; b < end;) {
          const uint32_t prefix = tree_.items[b].key >> below;
          const auto last = std::partition_point(
              tree_.items.begin() + b, tree_.items.begin() + end,
              [&](const KeyedIndex& item) { return item.key >> below == prefix; });
          const auto e = static_cast<uint32_t>(last - tree_.items.begin());
          parts.push_back({b, e});
          b = e;
        }
      }
      if (parts.size() < 2) {
        build(index, begin, end, 0);
        return;
      }
    }
    const auto first = static_cast<uint32_t>(tree_.nodes.size());
    tree_.nodes.resize(first + parts.size());
    tree_.nodes[index].first_child = first;
    tree_.nodes[index].child_count = static_cast<uint32_t>(parts.size());
    for (uint32_t i = 0; i < parts.size(); ++i) {
      build(first + i, parts[i].begin, parts[i].end, below);
    }
  }

 private:
  void add_leaf(uint32_t index, uint32_t begin, uint32_t end) {
    const uint32_t blocks = (end - begin + coverage_lanes - 1) / coverage_lanes;
    tree_.nodes[index].leaf = static_cast<uint32_t>(tree_.leaves.size());
    tree_.leaves.push_back({begin, end - begin, tree_.block_count, blocks});
    tree_.block_count += blocks;
  }

  ReceiverTree& tree_;
};

void build_nodes(ReceiverTree& tree) {
  tree.leaves.clear();
  tree.nodes.clear();
  tree.block_count = 0;
  TreeBuilder builder(tree);
  const auto count = static_cast<uint32_t>(tree.items.size());
  for (uint32_t begin = 0; begin < count;) {
    const uint32_t view = tree.items[begin].key >> key_bits;
    const auto last =
        std::partition_point(tree.items.begin() + begin, tree.items.end(),
                             [&](const KeyedIndex& item) { return item.key >> key_bits == view; });
    const auto end = static_cast<uint32_t>(last - tree.items.begin());
    tree.views[view].root = static_cast<uint32_t>(tree.nodes.size());
    tree.nodes.emplace_back();
    builder.build(tree.views[view].root, begin, end, key_bits);
    begin = end;
  }
}

/// Receivers lie anywhere: they are asked for so many before their turn.
constexpr uint32_t fetch_ahead = 2 * coverage_lanes;

void project_leaf(const LearnedReceivers& receivers, const LightViews& lights,
                  const CoverageKernels& kernels, ReceiverTree& tree, const ReceiverLeaf& leaf) {
  const uint32_t view = tree.items[leaf.first_item].key >> key_bits;
  const uint32_t end = leaf.first_item + leaf.item_count;
  uint32_t index[coverage_lanes];
  for (uint32_t b = 0; b < leaf.block_count; ++b) {
    const uint32_t first = leaf.first_item + b * coverage_lanes;
    const auto count = static_cast<int>(std::min<uint32_t>(coverage_lanes, end - first));
    for (int lane = 0; lane < count; ++lane) {
      const uint32_t item = first + static_cast<uint32_t>(lane);
      index[lane] = tree.items[item].index;
      __builtin_prefetch(&receivers.spots[tree.items[std::min(item + fetch_ahead, end - 1)].index]);
    }
    const uint32_t block = leaf.first_block + b;
    kernels.project(receivers.spots.data(), lights.views[view], index, count,
                    &tree.blocks[size_t{block} * coverage_block_floats], tree.bounds_of(block));
  }
}

}  // namespace

void build_receiver_tree(const LearnedReceivers& receivers, const LightViews& lights,
                         PixelShare share, const CoverageKernels& kernels, ReceiverTree& tree,
                         std::vector<ReceiverState>& states, std::vector<KeyedIndex>& scratch) {
  const size_t count = receivers.count();
  const size_t tiles = receivers.tile_spots.size();
  states.resize(count);
  // Each tile writes where its receivers stand; then they are moved together.
  std::vector<KeyedIndex>& placed = scratch;
  placed.resize(count);
  const ReceiverPlacer placer(receivers, lights);
  std::vector<TileSums> sums(tiles);
  parallel_for(tiles, 4, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      const LearnedReceivers::Range& range = receivers.tile_spots[t];
      size_t out = range.first;
      for (size_t i = range.first; i < range.end(share); ++i) {
        states[i] = find_state(receivers, lights, i);
        if (states[i] == ReceiverState::covered) placed[out++] = placer.place(i, sums[t]);
        sums[t].has_near |= states[i] == ReceiverState::near;
      }
    }
  });
  tree.has_near = std::ranges::any_of(sums, &TileSums::has_near);
  tree.views = {};
  std::vector<size_t> first(tiles);
  size_t covered = 0;
  for (size_t t = 0; t < tiles; ++t) {
    first[t] = covered;
    covered += sums[t].covered;
    for (size_t v = 0; v < max_light_views; ++v) {
      const ReceiverTree::View& from = sums[t].views[v];
      ReceiverTree::View& view = tree.views[v];
      if (!from.is_used) continue;
      view.w_low = view.is_used ? std::min(view.w_low, from.w_low) : from.w_low;
      view.is_used = true;
    }
  }
  tree.items.resize(covered);
  parallel_for(tiles, 16, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      std::copy_n(placed.begin() + static_cast<ptrdiff_t>(receivers.tile_spots[t].first),
                  sums[t].covered, tree.items.begin() + static_cast<ptrdiff_t>(first[t]));
    }
  });
  sort_by_key(tree.items, scratch);
  build_nodes(tree);
  tree.blocks.resize(size_t{tree.block_count} * coverage_block_floats);
  for (auto& bounds : tree.bounds) bounds.resize(tree.block_count + coverage_lanes);
  parallel_for(tree.leaves.size(), 8, [&](size_t begin, size_t end) {
    for (size_t l = begin; l < end; ++l) {
      project_leaf(receivers, lights, kernels, tree, tree.leaves[l]);
    }
  });
  bound_lit_receivers(tree);
}

void bound_lit_receivers(ReceiverTree& tree) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  const auto merge = [](ReceiverNode& a, const ReceiverNode& b) {
    a.u_low = std::min(a.u_low, b.u_low);
    a.u_high = std::max(a.u_high, b.u_high);
    a.v_low = std::min(a.v_low, b.v_low);
    a.v_high = std::max(a.v_high, b.v_high);
    a.z_high = std::max(a.z_high, b.z_high);
    a.size_low = std::min(a.size_low, b.size_low);
  };
  for (size_t i = tree.nodes.size(); i-- > 0;) {
    ReceiverNode& node = tree.nodes[i];
    node.u_low = node.v_low = node.size_low = infinity;
    node.u_high = node.v_high = node.z_high = -infinity;
    for (uint32_t c = 0; c < node.child_count; ++c) merge(node, tree.nodes[node.first_child + c]);
    if (node.child_count > 0) continue;
    const ReceiverLeaf& leaf = tree.leaves[node.leaf];
    for (uint32_t b = 0; b < leaf.block_count; ++b) {
      const CoverageBounds bounds = tree.bounds_of(leaf.first_block + b);
      if (*bounds.z_high <= dark_depth) continue;
      merge(node, {*bounds.u_low, *bounds.u_high, *bounds.v_low, *bounds.v_high, *bounds.z_high,
                   *bounds.size_low});
    }
  }
}

}  // namespace relume
