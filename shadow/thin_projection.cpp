#include "shadow/thin_projection.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace relume {
namespace {

/// Nothing nearer to the light than this part of the nearest receiver's distance is drawn: it would
/// fill the picture.
constexpr float near_part = 1e-3f;
/// Primitives that reach farther out than so many times the picture are cut, so that their
/// coordinates stay exact.
constexpr float far_out = 8;
constexpr size_t stack_size = 256;
/// Coarser forms may lie off by this part of the smallest footprint that they may shade.
constexpr float level_error_part = 1;

struct Box {
  float u_low, u_high, v_low, v_high, z_low;
};

bool overlaps(const Box& box, const ReceiverNode& node) {
  return box.u_low <= node.u_high && box.u_high >= node.u_low && box.v_low <= node.v_high &&
         box.v_high >= node.v_low && box.z_low <= node.z_high;
}

/// Calls visit(node) for each leaf that the box may reach.
template <class Visit>
void for_each_leaf(const ReceiverTree& tree, uint32_t root, const Box& box,
                   std::vector<uint32_t>& stack, const Visit& visit) {
  if (stack.size() < stack_size) stack.resize(stack_size);
  uint32_t* top = stack.data();
  *top++ = root;
  while (top != stack.data()) {
    const ReceiverNode& node = tree.nodes[*--top];
    if (node.child_count == 0) {
      if (overlaps(box, node)) visit(node);
      continue;
    }
    if (static_cast<size_t>(top - stack.data()) + node.child_count > stack.size()) {
      const auto used = top - stack.data();
      stack.resize(2 * stack.size() + node.child_count);
      top = stack.data() + used;
    }
    for (uint32_t c = 0; c < node.child_count; ++c) {
      const ReceiverNode& child = tree.nodes[node.first_child + c];
      if (overlaps(box, child)) {
        *top++ = node.first_child + c;
      }
    }
  }
}

/// x, y, d and w as linear functions of a shape's local position.
struct ShapeView {
  float row[3][4];
  float k;
  float radius_scale;  ///< of strands

  vec4 point(vec3 p) const {
    const auto at = [&](int i) {
      return row[i][0] * p.x + row[i][1] * p.y + row[i][2] * p.z + row[i][3];
    };
    const float d = at(2);
    return {at(0), at(1), d, 1 + k * d};
  }
};

ShapeView make_shape_view(const CoverageView& view, const mat4x3& world_from_local,
                          const LearnedReceivers& receivers) {
  ShapeView result{};
  result.k = view.k;
  const double inverse = 1 / receivers.scale;
  for (int i = 0; i < 3; ++i) {
    const dvec3 row(view.row[i][0], view.row[i][1], view.row[i][2]);
    for (size_t column = 0; column < 3; ++column) {
      result.row[i][column] =
          static_cast<float>(glm::dot(row, dvec3(world_from_local[column])) * inverse);
    }
    const dvec3 origin = (dvec3(world_from_local[3]) - receivers.center) * inverse;
    result.row[i][3] =
        static_cast<float>(glm::dot(row, origin) + static_cast<double>(view.row[i][3]));
  }
  result.radius_scale = uniform_scale(world_from_local) * static_cast<float>(inverse);
  return result;
}

/// One piece of work, unpacked.
class ChunkProjector {
 public:
  ChunkProjector(const ReceiverTree& tree, const ReceiverTree::View& view, const ShapeView& shape,
                 ProjectionScratch& scratch, ProjectedGeometry& out)
      : tree_(tree), view_(view), shape_(shape), scratch_(scratch), out_(out) {
    near_w_ = near_part * view.w_low;
    const ReceiverNode& root = tree.nodes[view.root];
    const float u = root.u_high - root.u_low;
    const float v = root.v_high - root.v_low;
    u_low_ = root.u_low - far_out * u;
    u_high_ = root.u_high + far_out * u;
    v_low_ = root.v_low - far_out * v;
    v_high_ = root.v_high + far_out * v;
  }

  /// What the receivers that a chunk may reach say of it.
  struct ChunkReach {
    bool is_any = false;
    bool is_whole = false;                               ///< nothing of the chunk has to be cut
    float depth = std::numeric_limits<float>::lowest();  ///< of its nearest corner
    float w = 0;         ///< of its nearest corner, 0 = too near to tell
    float size_low = 0;  ///< size of the smallest footprint it may reach
  };

  /// `bounds`: local ones.
  ChunkReach find_reach(const Bounds& bounds) {
    unsigned outside = all_planes;
    unsigned outside_any = 0;
    bool is_near = false;
    ChunkReach reach;
    reach.w = std::numeric_limits<float>::infinity();
    Box box{std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
            std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
            std::numeric_limits<float>::infinity()};
    for (unsigned corner = 0; corner < 8; ++corner) {
      const vec3 p((corner & 1) != 0 ? bounds.high.x : bounds.low.x,
                   (corner & 2) != 0 ? bounds.high.y : bounds.low.y,
                   (corner & 4) != 0 ? bounds.high.z : bounds.low.z);
      const vec4 q = shape_.point(p);
      const unsigned beyond = outside_planes(q);
      outside &= beyond;
      outside_any |= beyond;
      is_near |= !(q.w > near_w_);
      if (is_near) continue;
      extend(box, q.x / q.w, q.y / q.w, q.z / q.w);
      reach.w = std::min(reach.w, q.w);
    }
    if (outside != 0) return {};
    if (is_near) return {true};
    reach.is_whole = outside_any == 0;
    reach.depth = box.z_low;
    reach.size_low = std::numeric_limits<float>::infinity();
    for_each_leaf(tree_, view_.root, box, scratch_.stack, [&](const ReceiverNode& node) {
      reach.is_any = true;
      reach.size_low = std::min(reach.size_low, node.size_low);
    });
    return reach;
  }

  /// False when nothing of the chunk within the local bounds reaches a leaf. Its pieces come next.
  bool start_chunk(const Bounds& bounds) {
    const ChunkReach reach = find_reach(bounds);
    is_chunk_whole_ = reach.is_whole;
    return reach.is_any;
  }

  /// Projects the points of a piece; false when nothing of it reaches a leaf. What is
  /// added then has to belong to the piece.
  bool project_piece(const vec4* points, uint32_t count) {
    scratch_.points.resize(count);
    scratch_.projected.resize(count);
    constexpr float infinity = std::numeric_limits<float>::infinity();
    Box box{infinity, -infinity, infinity, -infinity, infinity};
    bool is_whole = true;
    unsigned outside = all_planes;
    for (uint32_t i = 0; i < count; ++i) {
      const vec4 p = shape_.point(vec3(points[i]));
      scratch_.points[i] = p;
      const unsigned beyond = is_chunk_whole_ ? 0 : outside_planes(p);
      is_whole &= beyond == 0;
      // A strand's radius may reach in where its axis does not.
      outside &= points[i].w > 0 ? 0 : beyond;
      // A strand's half width is at most its radius over w, times the obliqueness of the view.
      // Points level with the light lie outside: the piece is not whole then, and the box not
      // looked at.
      const float inverse = p.w != 0 ? 1 / p.w : 0;
      const float u = p.x * inverse;
      const float v = p.y * inverse;
      scratch_.projected[i] = vec3(u, v, p.z * inverse);
      const float oblique = 1 + shape_.k * (std::abs(u) + std::abs(v));
      const float pad = points[i].w * shape_.radius_scale * std::abs(inverse) * oblique;
      extend(box, u - pad, v - pad, p.z * inverse);
      extend(box, u + pad, v + pad, p.z * inverse);
    }
    if (outside != 0) return false;
    start_ = view_.root;
    is_whole_ = is_whole;
    if (!is_whole) return true;
    if (!overlaps(box, tree_.nodes[start_])) return false;
    // Down while one child holds all that the piece reaches.
    while (tree_.nodes[start_].child_count > 0) {
      const ReceiverNode& node = tree_.nodes[start_];
      uint32_t reached = 0;
      uint32_t last = start_;
      for (uint32_t c = 0; c < node.child_count; ++c) {
        const ReceiverNode& child = tree_.nodes[node.first_child + c];
        if (!overlaps(box, child)) continue;
        ++reached;
        last = node.first_child + c;
      }
      if (reached == 0) return false;
      if (reached > 1) break;
      start_ = last;
    }
    return true;
  }

  /// The segment between projected points a and b, with radii.
  void add_segment(uint32_t a, uint32_t b, float radius_a, float radius_b, uint32_t piece) {
    vec4 p = scratch_.points[a];
    vec4 q = scratch_.points[b];
    if (!is_whole_ && !cut_segment(p, q, radius_a, radius_b)) return;
    // A strand is a ribbon that faces the light: half its width is seen across line of sight and
    // axis.
    const vec4 middle = 0.5f * (p + q);
    const vec3 sight(shape_.k * middle.x, shape_.k * middle.y, middle.w);
    const vec3 across = glm::cross(vec3(q - p), sight);
    const float length = glm::length(across);
    const float inverse_w = 1 / middle.w;
    const float u = middle.x * inverse_w;
    const float v = middle.y * inverse_w;
    CoverageSegment segment{};
    const vec3 start = picture_of(p);
    const vec3 end = picture_of(q);
    const float du = end.x - start.x;
    const float dv = end.y - start.y;
    const float run = std::sqrt(du * du + dv * dv);
    // Seen end on it has no width to speak of.
    if (!(length > 0) || !(run > 0)) return;
    const float eu = (across.x - u * shape_.k * across.z) / length;
    const float ev = (across.y - v * shape_.k * across.z) / length;
    const float inverse = 1 / run;
    const float scale = std::abs(eu * dv - ev * du) * inverse * shape_.radius_scale;
    const float half_end = radius_b * scale / q.w;
    segment.u = start.x;
    segment.v = start.y;
    segment.z = start.z;
    segment.du = du * inverse;
    segment.dv = dv * inverse;
    segment.length = run;
    segment.half = radius_a * scale / p.w;
    segment.half_slope = (half_end - segment.half) * inverse;
    segment.z_slope = (end.z - start.z) * inverse;
    segment.z_low = std::min(start.z, end.z);
    segment.half_high = std::max(segment.half, half_end);
    segment.piece = piece;
    const float half = segment.half_high;
    append(segment,
           {std::min(start.x, end.x) - half, std::max(start.x, end.x) + half,
            std::min(start.y, end.y) - half, std::max(start.y, end.y) + half, segment.z_low},
           out_.segments);
  }

  void add_triangle(uint32_t a, uint32_t b, uint32_t c, float opacity, uint32_t piece,
                    bool is_sheet, float slack) {
    CoverageTriangle primitive{};
    primitive.opacity = opacity;
    primitive.piece = piece;
    primitive.is_sheet = is_sheet ? 1 : 0;
    const Plane unknown;
    if (is_whole_) {
      append_triangle(primitive, slack, unknown, scratch_.projected[a], scratch_.projected[b],
                      scratch_.projected[c]);
      return;
    }
    vec4 corners[max_corners] = {scratch_.points[a], scratch_.points[b], scratch_.points[c]};
    const unsigned beyond[3] = {outside_planes(corners[0]), outside_planes(corners[1]),
                                outside_planes(corners[2])};
    if ((beyond[0] & beyond[1] & beyond[2]) != 0) return;
    if ((beyond[0] | beyond[1] | beyond[2]) == 0) {
      append_triangle(primitive, slack, unknown, scratch_.projected[a], scratch_.projected[b],
                      scratch_.projected[c]);
      return;
    }
    const Plane plane = find_plane(corners);
    const int count = cut_polygon(corners, 3);
    for (int i = 2; i < count; ++i) {
      append_triangle(primitive, slack, plane, picture_of(corners[0]), picture_of(corners[i - 1]),
                      picture_of(corners[i]));
    }
  }

 private:
  static constexpr int max_corners = 8;  ///< a triangle cut by five planes

  /// z = slope[0] u + slope[1] v + slope[2].
  struct Plane {
    bool is_known = false;
    float slope[3] = {};
  };

  /// From the corners in space: where a triangle is cut near the light, those of the picture are so
  /// far away that little is left of their last digits.
  static Plane find_plane(const vec4* corners) {
    const auto row = [&](int i) { return dvec3(corners[0][i], corners[1][i], corners[2][i]); };
    const dvec3 x = row(0);
    const dvec3 y = row(1);
    const dvec3 d = row(2);
    const dvec3 w = row(3);
    const double volume = glm::dot(x, glm::cross(y, w));
    const double size = glm::length(x) * glm::length(y) * glm::length(w);
    if (!(std::abs(volume) > 1e-9 * size)) return {};
    return {true,
            {static_cast<float>(glm::dot(d, glm::cross(y, w)) / volume),
             static_cast<float>(glm::dot(x, glm::cross(d, w)) / volume),
             static_cast<float>(glm::dot(x, glm::cross(y, d)) / volume)}};
  }

  static void extend(Box& box, float u, float v, float z) {
    box.u_low = std::min(box.u_low, u);
    box.u_high = std::max(box.u_high, u);
    box.v_low = std::min(box.v_low, v);
    box.v_high = std::max(box.v_high, v);
    box.z_low = std::min(box.z_low, z);
  }

  /// u, v and z.
  static vec3 picture_of(vec4 p) { return vec3(p) / p.w; }

  /// Nothing when the triangle has no area in the picture. `plane`: of its depths, if the corners
  /// do not tell.
  void append_triangle(CoverageTriangle& t, float slack, const Plane& plane, vec3 p, vec3 q,
                       vec3 r) {
    const vec3 a = q - p;
    const vec3 b = r - p;
    const float area = a.x * b.y - b.x * a.y;
    const float squares = a.x * a.x + a.y * a.y + b.x * b.x + b.y * b.y;
    if (!(std::abs(area) > 1e-7f * squares)) return;
    const vec3 corners[3] = {p, q, r};
    for (int i = 0; i < 3; ++i) {
      t.u[i] = corners[i].x;
      t.v[i] = corners[i].y;
    }
    t.zu = plane.is_known ? plane.slope[0] : (a.z * b.y - b.z * a.y) / area;
    t.zv = plane.is_known ? plane.slope[1] : (b.z * a.x - a.z * b.x) / area;
    t.z = plane.is_known ? plane.slope[2] + t.zu * p.x + t.zv * p.y : p.z;
    t.slack = slack * (1 + std::abs(t.zu) + std::abs(t.zv));
    const vec3 low = glm::min(p, glm::min(q, r));
    const vec3 high = glm::max(p, glm::max(q, r));
    t.z_low = low.z;
    t.z_high = high.z;
    append(t, {low.x, high.x, low.y, high.y, low.z}, out_.triangles);
  }

  /// Distance from the inner side of plane `plane` of 5, > 0 inside.
  float inside(vec4 p, int plane) const {
    switch (plane) {
      case 0:
        return p.w - near_w_;
      case 1:
        return p.x - u_low_ * p.w;
      case 2:
        return u_high_ * p.w - p.x;
      case 3:
        return p.y - v_low_ * p.w;
      default:
        return v_high_ * p.w - p.y;
    }
  }

  /// A bit for each plane that `p` lies outside of or on.
  unsigned outside_planes(vec4 p) const {
    unsigned planes = 0;
    for (int plane = 0; plane < 5; ++plane) planes |= inside(p, plane) > 0 ? 0u : 1u << plane;
    return planes;
  }
  static constexpr unsigned all_planes = 31;

  bool is_within(vec4 p) const {
    return inside(p, 0) > 0 && inside(p, 1) >= 0 && inside(p, 2) >= 0 && inside(p, 3) >= 0 &&
           inside(p, 4) >= 0;
  }

  bool cut_segment(vec4& p, vec4& q, float& radius_p, float& radius_q) const {
    if (is_within(p) && is_within(q)) return true;
    float begin = 0;
    float end = 1;
    for (int plane = 0; plane < 5; ++plane) {
      const float a = inside(p, plane);
      const float b = inside(q, plane);
      if (!(a > 0) && !(b > 0)) return false;
      if (a > 0 && b > 0) continue;
      const float t = a / (a - b);
      if (a > 0) {
        end = std::min(end, t);
      } else {
        begin = std::max(begin, t);
      }
    }
    if (!(begin < end)) return false;
    const vec4 step = q - p;
    const float radius_step = radius_q - radius_p;
    q = p + end * step;
    p += begin * step;
    radius_q = radius_p + end * radius_step;
    radius_p += begin * radius_step;
    return p.w > 0 && q.w > 0;
  }

  int cut_polygon(vec4 (&corners)[max_corners], int count) const {
    for (int plane = 0; plane < 5 && count > 0; ++plane) {
      vec4 cut[max_corners];
      int kept = 0;
      for (int i = 0; i < count; ++i) {
        const vec4 p = corners[i];
        const vec4 q = corners[i + 1 < count ? i + 1 : 0];
        const float a = inside(p, plane);
        const float b = inside(q, plane);
        if (a > 0 && kept < max_corners) cut[kept++] = p;
        if ((a > 0) != (b > 0) && kept < max_corners) cut[kept++] = p + (a / (a - b)) * (q - p);
      }
      std::copy_n(cut, kept, corners);
      count = kept;
    }
    for (int i = 0; i < count; ++i) {
      if (!(corners[i].w > 0)) return 0;
    }
    return count;
  }

  template <class Primitive>
  void append(const Primitive& primitive, const Box& box, ProjectedPrimitives<Primitive>& out) {
    const auto number = static_cast<uint32_t>(out.primitives.size());
    bool reached = false;
    for_each_leaf(tree_, start_, box, scratch_.stack, [&](const ReceiverNode& node) {
      out.reaches.push_back({node.leaf, number});
      reached = true;
    });
    if (reached) out.primitives.push_back(primitive);
  }

  const ReceiverTree& tree_;
  const ReceiverTree::View& view_;
  const ShapeView& shape_;
  ProjectionScratch& scratch_;
  ProjectedGeometry& out_;
  uint32_t start_ = 0;           ///< node that holds all that the piece reaches
  bool is_whole_ = false;        ///< nothing of the piece has to be cut
  bool is_chunk_whole_ = false;  ///< nor of the chunk
  float near_w_ = 0;
  float u_low_ = 0;
  float u_high_ = 0;
  float v_low_ = 0;
  float v_high_ = 0;
};

}  // namespace

namespace {

/// Coarser forms may lie off by a part of the smallest footprint.
void allow_error(float scale, float w, float size_low, ProjectionWork& work) {
  if (!(w > 0) || !(scale > 0)) return;
  work.most_error = level_error_part * size_low * w / scale;
  work.slack = scale / w * std::max(1.0f, 1 / w);
}

}  // namespace

std::vector<ProjectionWork> list_projection_work(const ThinGeometry& geometry,
                                                 const LearnedReceivers& receivers,
                                                 const LightViews& lights,
                                                 const ReceiverTree& tree) {
  constexpr size_t part_instances = 256;
  const size_t parts = (geometry.instances.size() + part_instances - 1) / part_instances;
  std::vector<std::vector<ProjectionWork>> found(parts);
  parallel_for(parts, 1, [&](size_t begin, size_t end) {
    ProjectionScratch scratch;
    ProjectedGeometry unused;
    for (size_t i = begin * part_instances;
         i < std::min(end * part_instances, geometry.instances.size()); ++i) {
      const ThinInstance& instance = geometry.instances[i];
      const ThinShape& shape = geometry.shapes[instance.shape];
      for (uint32_t v = 0; v < tree.views.size(); ++v) {
        if (!tree.views[v].is_used) continue;
        const ShapeView view =
            make_shape_view(lights.views[v], instance.world_from_local, receivers);
        ChunkProjector projector(tree, tree.views[v], view, scratch, unused);
        for (uint32_t c = 0; c < shape.chunks.size(); ++c) {
          ProjectionWork work{v, static_cast<uint32_t>(i), c};
          const auto reach = projector.find_reach(shape.chunks[c].bounds);
          if (!reach.is_any) continue;
          work.depth = reach.depth;
          allow_error(view.radius_scale, reach.w, reach.size_low, work);
          found[i / part_instances].push_back(work);
        }
      }
    }
  });
  std::vector<ProjectionWork> all;
  for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
  std::ranges::stable_sort(all, {}, &ProjectionWork::depth);
  return all;
}

namespace {

void project_strand(const ThinShape& shape, const ThinPiece& piece, uint32_t number,
                    ChunkProjector& projector) {
  const vec4* points = &shape.vertices[piece.first_vertex];
  if (!projector.project_piece(points, piece.vertex_count)) return;
  for (uint32_t v = 0; v + 1 < piece.vertex_count; ++v) {
    projector.add_segment(v, v + 1, points[v].w, points[v + 1].w, number);
  }
}

/// `shape`: a ThinShape or a ThinLevel.
template <class Shape>
void project_leaf(const Shape& shape, const ThinPiece& piece, uint32_t number, float slack,
                  ChunkProjector& projector) {
  if (!projector.project_piece(&shape.vertices[piece.first_vertex], piece.vertex_count)) return;
  for (uint32_t i = piece.first_triangle; i < piece.first_triangle + piece.triangle_count; ++i) {
    const uvec3 t = shape.triangles[i] - piece.first_vertex;
    projector.add_triangle(t.x, t.y, t.z, shape.opacity.empty() ? 1.0f : shape.opacity[i], number,
                           piece.is_sheet, slack);
  }
}

/// The coarsest form of a piece that lies off by no more than `most_error`, or nothing.
const ThinLevel* choose_level(const ThinShape& shape, uint32_t piece, float most_error) {
  const ThinLevel* chosen = nullptr;
  for (const ThinLevel& level : shape.levels) {
    if (!(level.error[piece] <= most_error)) break;
    chosen = &level;
  }
  return chosen;
}

}  // namespace

void project_chunk(const ThinGeometry& geometry, const LearnedReceivers& receivers,
                   const LightViews& lights, const ReceiverTree& tree, const ProjectionWork& work,
                   ProjectionScratch& scratch, ProjectedGeometry& out) {
  const ThinInstance& instance = geometry.instances[work.instance];
  const ThinShape& shape = geometry.shapes[instance.shape];
  const ThinChunk& chunk = shape.chunks[work.chunk];
  const ShapeView view =
      make_shape_view(lights.views[work.view], instance.world_from_local, receivers);
  ChunkProjector projector(tree, tree.views[work.view], view, scratch, out);
  if (!projector.start_chunk(chunk.bounds)) return;
  for (uint32_t p = chunk.first_piece; p < chunk.first_piece + chunk.piece_count; ++p) {
    const uint32_t number = instance.first_piece + p;
    if (shape.is_strands) {
      project_strand(shape, shape.pieces[p], number, projector);
    } else if (const ThinLevel* level = choose_level(shape, p, work.most_error)) {
      const float slack = work.slack * level->error[p];
      project_leaf(*level, level->pieces[p], number, slack, projector);
    } else {
      project_leaf(shape, shape.pieces[p], number, 0, projector);
    }
  }
}

}  // namespace relume
