#pragma once

#include "shadow/receiver_tree.h"
#include "shadow/thin_geometry.h"

namespace relume {

/// A chunk of thin geometry in one view.
struct ProjectionWork {
  uint32_t view = 0;
  uint32_t instance = 0;
  uint32_t chunk = 0;
  float depth = 0;       ///< of its nearest corner
  float most_error = 0;  ///< local: how far coarser forms may lie off
  float slack = 0;  ///< how far that is in the light's picture, in depth too, for an error of 1
};

/// The chunks that may reach a receiver, in each view that has any, near ones first.
std::vector<ProjectionWork> list_projection_work(const ThinGeometry& geometry,
                                                 const LearnedReceivers& receivers,
                                                 const LightViews& lights,
                                                 const ReceiverTree& tree);

/// Primitives in the light's picture and the leaves of the tree that each may shade.
template <class Primitive>
struct ProjectedPrimitives {
  struct Reach {
    uint32_t leaf;
    uint32_t primitive;
  };
  std::vector<Primitive> primitives;
  std::vector<Reach> reaches;
};
struct ProjectedGeometry {
  ProjectedPrimitives<CoverageSegment> segments;
  ProjectedPrimitives<CoverageTriangle> triangles;
};

/// What projecting needs of memory; one a thread.
struct ProjectionScratch {
  std::vector<vec4> points;     ///< x, y, d, w
  std::vector<vec3> projected;  ///< u, v, z
  std::vector<uint32_t> stack;
};

/// Projects one chunk and appends what reaches a leaf.
void project_chunk(const ThinGeometry& geometry, const LearnedReceivers& receivers,
                   const LightViews& lights, const ReceiverTree& tree, const ProjectionWork& work,
                   ProjectionScratch& scratch, ProjectedGeometry& out);

}  // namespace relume
