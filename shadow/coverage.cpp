#include "shadow/coverage.h"

#include <atomic>

#include "core/base/bytes_of.h"
#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/timer.h"
#include "shadow/members.h"

namespace relume {
namespace {

/// Parts that geometry is projected in; their number never depends on the threads.
constexpr size_t group_count = 32;
/// Primitives that are looked at in one go, the first time; those that reach a receiver are held.
/// What they make dark, the later ones skip.
constexpr uint64_t first_round_primitives = uint64_t{1} << 19;
/// Each time it is so many more, up to a limit.
constexpr double round_growth = 1.3;
constexpr uint64_t round_primitives = uint64_t{1} << 19;
/// As in make_thin_geometry.
constexpr float max_thin_width_px = 32;
/// To draw a triangle costs about as much as so many rays.
constexpr uint64_t receivers_per_drawn_triangle = 4;
/// Marks receivers that rays have to decide.
constexpr float undecided = -1;

uint64_t primitive_count(const ThinGeometry& geometry, const ProjectionWork& work) {
  const ThinShape& shape = geometry.shapes[geometry.instances[work.instance].shape];
  return shape.chunks[work.chunk].primitive_count;
}

template <class Primitive>
void clear(ProjectedPrimitives<Primitive>& projected) {
  projected.primitives.clear();
  projected.reaches.clear();
}

/// Primitives sorted by leaf.
class LeafOrder {
 public:
  template <class Primitive>
  void sort(const ProjectedPrimitives<Primitive>& projected, size_t leaves) {
    start_.assign(leaves + 2, 0);
    for (const auto& reach : projected.reaches) ++start_[reach.leaf + 2];
    for (size_t l = 2; l < start_.size(); ++l) start_[l] += start_[l - 1];
    order_.resize(projected.reaches.size());
    for (const auto& reach : projected.reaches) order_[start_[reach.leaf + 1]++] = reach.primitive;
  }

  template <class Primitive>
  CoverageList<Primitive> list(const ProjectedPrimitives<Primitive>& projected, size_t leaf) const {
    return {projected.primitives.data(), order_.data() + start_[leaf],
            start_[leaf + 1] - start_[leaf]};
  }

 private:
  std::vector<uint32_t> start_;  ///< of each leaf, and the end
  std::vector<uint32_t> order_;
};

}  // namespace

CoverageVisibility::CoverageVisibility(const Tracer& tracer, const RelightCache& cache,
                                       InstructionSet set)
    : view_(cache),
      geometry_(make_thin_geometry(tracer.scene(), cache.info().height, max_thin_width_px,
                                   view_.count() / receivers_per_drawn_triangle)),
      all_rays_(tracer),
      kernels_(coverage_kernels(choose_instruction_set(set))),
      receivers_(learn_receivers(view_, tracer, geometry_)),
      visibility_(view_.count(), 1.0f) {
  if (geometry_.solids.instances.empty()) return;
  // Where the scene was too large to flatten, so that memory does not grow with its instances.
  if (!tracer.stats().flattened) geometry_.solids.instancing = Instancing::instance;
  solids_.emplace(geometry_.solids);
}

uint64_t CoverageVisibility::memory_bytes() const {
  uint64_t bytes = geometry_.memory_bytes() + receivers_.memory_bytes() + tree_.memory_bytes() +
                   bytes_of(states_, scratch_, seen_, visibility_, groups_);
  for (const ProjectedGeometry& group : groups_) {
    bytes += bytes_of(group.segments.primitives, group.segments.reaches, group.triangles.primitives,
                      group.triangles.reaches);
  }
  return solids_ ? bytes + solids_->stats().memory_bytes : bytes;
}

void CoverageVisibility::prepare_share(const Light& light, PixelShare share) {
  stats_ = CoverageStats();
  const Timer timer;
  const LightViews lights = make_light_views(light, receivers_.center, receivers_.scale);
  build_receiver_tree(receivers_, lights, share, kernels_, tree_, states_, scratch_);
  stats_.build_ms = timer.ms();
  stats_.receivers = tree_.items.size();
  rasterise(lights);
  const Timer trace_timer;
  collect(share);
  trace(light, share);
  stats_.trace_ms = trace_timer.ms();
}

void CoverageVisibility::rasterise(const LightViews& lights) {
  if (geometry_.empty() || tree_.leaves.empty()) return;
  const Timer timer;
  const std::vector<ProjectionWork> work =
      list_projection_work(geometry_, receivers_, lights, tree_);
  stats_.project_ms += timer.ms();
  uint64_t limit = first_round_primitives;
  for (size_t begin = 0; begin < work.size();) {
    uint64_t primitives = 0;
    size_t end = begin;
    while (end < work.size() && primitives < limit) {
      primitives += primitive_count(geometry_, work[end++]);
    }
    rasterise_part(lights, std::span(work).subspan(begin, end - begin));
    begin = end;
    limit = std::min(round_primitives,
                     static_cast<uint64_t>(round_growth * static_cast<double>(limit)));
    if (begin < work.size()) bound_lit_receivers(tree_);
  }
}

void CoverageVisibility::rasterise_part(const LightViews& lights,
                                        std::span<const ProjectionWork> work) {
  const Timer timer;
  groups_.resize(group_count);
  parallel_for(group_count, 1, [&](size_t begin, size_t end) {
    ProjectionScratch scratch;
    for (size_t g = begin; g < end; ++g) {
      clear(groups_[g].segments);
      clear(groups_[g].triangles);
      for (size_t i = work.size() * g / group_count; i < work.size() * (g + 1) / group_count; ++i) {
        project_chunk(geometry_, receivers_, lights, tree_, work[i], scratch, groups_[g]);
      }
    }
  });
  for (const ProjectedGeometry& group : groups_) {
    stats_.primitives += group.segments.primitives.size() + group.triangles.primitives.size();
  }
  stats_.project_ms += timer.ms();
  const Timer shade_timer;
  shade_leaves();
  stats_.shade_ms += shade_timer.ms();
}

void CoverageVisibility::shade_leaves() {
  const size_t leaves = tree_.leaves.size();
  std::vector<LeafOrder> segments(group_count);
  std::vector<LeafOrder> triangles(group_count);
  parallel_for(group_count, 1, [&](size_t begin, size_t end) {
    for (size_t g = begin; g < end; ++g) {
      segments[g].sort(groups_[g].segments, leaves);
      triangles[g].sort(groups_[g].triangles, leaves);
    }
  });
  std::atomic<uint64_t> tests{0};
  parallel_for(leaves, 4, [&](size_t begin, size_t end) {
    for (size_t l = begin; l < end; ++l) {
      const ReceiverLeaf& leaf = tree_.leaves[l];
      CoverageTask task{};
      task.blocks = &tree_.blocks[size_t{leaf.first_block} * coverage_block_floats];
      task.bounds = tree_.bounds_of(leaf.first_block);
      task.block_count = static_cast<int>(leaf.block_count);
      std::array<CoverageList<CoverageSegment>, group_count> segment_lists;
      std::array<CoverageList<CoverageTriangle>, group_count> triangle_lists;
      int segment_count = 0;
      int triangle_count = 0;
      for (size_t g = 0; g < group_count; ++g) {
        const auto some_segments = segments[g].list(groups_[g].segments, l);
        if (some_segments.count > 0) segment_lists[segment_count++] = some_segments;
        const auto some_triangles = triangles[g].list(groups_[g].triangles, l);
        if (some_triangles.count > 0) triangle_lists[triangle_count++] = some_triangles;
      }
      if (segment_count > 0) kernels_.shade_segments(task, segment_lists.data(), segment_count);
      if (triangle_count > 0) kernels_.shade_triangles(task, triangle_lists.data(), triangle_count);
      tests += task.tests;
    }
  });
  stats_.tests += tests;
}

void CoverageVisibility::collect(PixelShare share) {
  seen_.resize(receivers_.count());
  parallel_for(tree_.leaves.size(), 64, [&](size_t begin, size_t end) {
    for (size_t l = begin; l < end; ++l) {
      const ReceiverLeaf& leaf = tree_.leaves[l];
      for (uint32_t i = 0; i < leaf.item_count; ++i) {
        const uint32_t block = leaf.first_block + i / coverage_lanes;
        const float visible = tree_.blocks[size_t{block} * coverage_block_floats +
                                           array_visible * coverage_lanes + i % coverage_lanes];
        seen_[tree_.items[leaf.first_item + i].index] = visible > dark_visibility ? visible : 0.0f;
      }
    }
  });
  parallel_for(view_.tile_count(), 16, [&](size_t begin, size_t end) {
    for (size_t tile = begin; tile < end; ++tile) {
      const LearnedReceivers::Range& range = receivers_.tile_links[tile];
      const std::span<const ReceiverLink> links(receivers_.links);
      collect_receivers(links.subspan(range.first, range.end(share) - range.first));
    }
  });
}

void CoverageVisibility::collect_receivers(std::span<const ReceiverLink> links) {
  for (size_t i = 0; i < links.size();) {
    const uint32_t receiver = links[i].receiver;
    float sum = 0;
    bool is_near = false;
    for (; i < links.size() && links[i].receiver == receiver; ++i) {
      const ReceiverState state = states_[links[i].spot];
      is_near |= state == ReceiverState::near;
      if (state == ReceiverState::hidden) continue;
      sum += links[i].share * (state == ReceiverState::covered ? seen_[links[i].spot] : 1.0f);
    }
    visibility_[receiver] = is_near ? undecided : std::min(sum, 1.0f);
  }
}

void CoverageVisibility::trace(const Light& light, PixelShare share) {
  all_rays_.aim(light);
  std::optional<ShadowRays> solid_rays;
  if (solids_) solid_rays.emplace(*solids_).aim(light);
  if (!solid_rays && !tree_.has_near) return;
  const auto trace_group = [&](const ReceiverGroup& group) {
    const Member* members = group.members.data();
    for (int lane = 0; lane < group.receivers.count; ++lane) {
      float& visible = visibility_[group.receivers.first + static_cast<size_t>(lane)];
      if (group.receivers.weight[lane] > 0 && visible != 0) {
        if (visible == undecided) {
          visible = trace_members(all_rays_, group, lane, members, max_members);
        } else if (solid_rays) {
          visible *= trace_members(*solid_rays, group, lane, members, 1);
        }
      }
      members += group.footprints[static_cast<size_t>(lane)].stored_members;
    }
  };
  parallel_for(view_.tile_count(), 1, [&](size_t begin, size_t end) {
    for (size_t tile = begin; tile < end; ++tile) view_.visit_tile(tile, trace_group, share);
  });
}

void CoverageVisibility::visibility(const Receivers& receivers, float* visibility) const {
  CHECK_MSG(receivers.first + receivers.count <= visibility_.size(), "{} {} {}", receivers.first,
            receivers.count, visibility_.size());
  std::copy_n(&visibility_[receivers.first], receivers.count, visibility);
}

}  // namespace relume
