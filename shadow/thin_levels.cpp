#include "shadow/thin_levels.h"

#include <algorithm>
#include <map>
#include <optional>
#include <unordered_map>

#include "core/base/parallel.h"

namespace relume {
namespace {

/// Levels have this part of the triangles of the one before, or less.
constexpr double level_part = 0.6;
constexpr int most_levels = 6;
/// A triangle's normal may turn to this cosine.
constexpr double least_turn_cosine = 0.3;
/// A piece keeps this part of its area, or more; its opacity makes up for the rest.
constexpr double least_area_part = 0.7;
/// Larger pieces stay as they are: the time it takes grows with their square.
constexpr uint32_t most_piece_triangles = 512;

double distance_to_segment(dvec3 p, dvec3 a, dvec3 b) {
  const dvec3 d = b - a;
  const double squared = glm::dot(d, d);
  const double t = squared > 0 ? std::clamp(glm::dot(p - a, d) / squared, 0.0, 1.0) : 0.0;
  return glm::distance(p, a + t * d);
}

double distance_to_triangle(dvec3 p, dvec3 a, dvec3 b, dvec3 c) {
  const dvec3 n = glm::cross(b - a, c - a);
  const double squared = glm::dot(n, n);
  if (squared > 0) {
    const double u = glm::dot(glm::cross(b - a, p - a), n) / squared;
    const double v = glm::dot(glm::cross(p - a, c - a), n) / squared;
    if (u >= 0 && v >= 0 && u + v <= 1) return std::abs(glm::dot(p - a, n)) / std::sqrt(squared);
  }
  return std::min(distance_to_segment(p, a, b),
                  std::min(distance_to_segment(p, b, c), distance_to_segment(p, c, a)));
}

/// One piece while it loses vertices.
class PieceSimplifier {
 public:
  PieceSimplifier(const ThinShape& shape, const ThinPiece& piece) {
    // Vertices at one position are one.
    std::map<std::array<float, 3>, uint32_t> at;
    std::vector<uint32_t> welded;
    for (uint32_t v = 0; v < piece.vertex_count; ++v) {
      const vec4 p = shape.vertices[piece.first_vertex + v];
      const auto next = static_cast<uint32_t>(points_.size());
      const auto [place, is_new] = at.emplace(std::array{p.x, p.y, p.z}, next);
      if (is_new) points_.emplace_back(p);
      welded.push_back(place->second);
    }
    for (uint32_t i = piece.first_triangle; i < piece.first_triangle + piece.triangle_count; ++i) {
      const uvec3 t = shape.triangles[i] - piece.first_vertex;
      const float opacity = shape.opacity.empty() ? 1.0f : shape.opacity[i];
      const Triangle triangle{uvec3(welded[t.x], welded[t.y], welded[t.z])};
      covered_ += area_of(triangle) * static_cast<double>(opacity);
      area_ += area_of(triangle);
      if (!is_degenerate(triangle)) triangles_.push_back(triangle);
    }
    least_area_ = least_area_part * area_;
    moved_.assign(points_.size(), 0.0);
    triangles_of_.resize(points_.size());
    border_of_.resize(points_.size());
    best_of_.resize(points_.size());
    is_stale_.assign(points_.size(), true);
  }

  size_t triangle_count() const { return triangles_.size(); }
  double error() const { return error_; }

  /// Takes one vertex out; false when none can go.
  bool step() {
    find_neighbours();
    const Collapse best = find_best();
    if (!best.is_found) return false;
    for (const uint32_t i : triangles_of_[best.from]) {
      for (int c = 0; c < 3; ++c) is_stale_[triangles_[i].corner[c]] = true;
    }
    for (Triangle& triangle : triangles_) {
      for (int i = 0; i < 3; ++i) {
        if (triangle.corner[i] == best.from) triangle.corner[i] = best.to;
      }
    }
    std::erase_if(triangles_, is_degenerate);
    moved_[best.to] = std::max(moved_[best.to], best.cost);
    area_ = 0;
    for (const Triangle& triangle : triangles_) area_ += area_of(triangle);
    error_ = std::max(error_, best.cost);
    return true;
  }

  void append(ThinLevel& level, bool is_sheet) const {
    ThinPiece piece{static_cast<uint32_t>(level.vertices.size()), 0,
                    static_cast<uint32_t>(level.triangles.size()),
                    static_cast<uint32_t>(triangles_.size()), is_sheet};
    std::unordered_map<uint32_t, uint32_t> index_of;
    for (const Triangle& triangle : triangles_) {
      uvec3 corners;
      for (int i = 0; i < 3; ++i) {
        const auto next = static_cast<uint32_t>(level.vertices.size());
        const auto [place, is_new] = index_of.emplace(triangle.corner[i], next);
        if (is_new) level.vertices.emplace_back(vec3(points_[triangle.corner[i]]), 0.0f);
        corners[i] = place->second;
      }
      level.triangles.push_back(corners);
    }
    const double gain = area_ > 0 ? covered_ / area_ : 0;
    level.opacity.resize(level.triangles.size(), static_cast<float>(gain));
    piece.vertex_count = static_cast<uint32_t>(level.vertices.size()) - piece.first_vertex;
    level.pieces.push_back(piece);
  }

 private:
  struct Triangle {
    uvec3 corner;
  };
  struct Collapse {
    bool is_found = false;
    uint32_t from = 0;
    uint32_t to = 0;
    double cost = 0;
    double area = 0;  ///< by which the piece's grows
  };

  static bool is_degenerate(const Triangle& t) {
    return t.corner.x == t.corner.y || t.corner.y == t.corner.z || t.corner.z == t.corner.x;
  }
  dvec3 normal_of(const Triangle& t) const {
    const dvec3 a = points_[t.corner.x];
    return glm::cross(points_[t.corner.y] - a, points_[t.corner.z] - a);
  }
  double area_of(const Triangle& t) const { return 0.5 * glm::length(normal_of(t)); }

  /// Per vertex: its triangles, and the vertices that a border leads to.
  void find_neighbours() {
    for (auto& list : triangles_of_) list.clear();
    for (auto& list : border_of_) list.clear();
    for (uint32_t i = 0; i < triangles_.size(); ++i) {
      for (int c = 0; c < 3; ++c) triangles_of_[triangles_[i].corner[c]].push_back(i);
    }
    const auto uses = [this](uint32_t a, uint32_t b) {
      return std::ranges::count_if(triangles_of_[a], [&](uint32_t i) {
        const uvec3 t = triangles_[i].corner;
        return t.x == b || t.y == b || t.z == b;
      });
    };
    for (const Triangle& t : triangles_) {
      for (int c = 0; c < 3; ++c) {
        const uint32_t a = t.corner[c];
        const uint32_t b = t.corner[(c + 1) % 3];
        if (uses(a, b) != 1) continue;
        border_of_[a].push_back(b);
        border_of_[b].push_back(a);
      }
    }
  }

  /// The cheapest of all. What is known of a vertex stays true while its triangles do.
  Collapse find_best() {
    while (true) {
      Collapse best;
      for (uint32_t v = 0; v < points_.size(); ++v) {
        if (is_stale_[v]) update_best_of(v);
        const Collapse& own = best_of_[v];
        if (own.is_found && (!best.is_found || own.cost < best.cost)) best = own;
      }
      if (!best.is_found || area_ + best.area >= least_area_) return best;
      is_stale_[best.from] = true;  // another way of it may leave more
    }
  }

  void update_best_of(uint32_t vertex) {
    Collapse& best = best_of_[vertex];
    best.is_found = false;
    for (const uint32_t i : triangles_of_[vertex]) {
      for (int c = 0; c < 3; ++c) {
        const uint32_t to = triangles_[i].corner[c];
        if (to != vertex) consider(vertex, to, best);
      }
    }
    is_stale_[vertex] = false;
  }

  /// Keeps the cheaper of `best` and moving `from` to `to`.
  void consider(uint32_t from, uint32_t to, Collapse& best) const {
    const std::vector<uint32_t>& border = border_of_[from];
    double cost = 0;
    if (!border.empty()) {
      if (border.size() != 2 || (border[0] != to && border[1] != to)) return;
      const uint32_t other = border[0] == to ? border[1] : border[0];
      cost = distance_to_segment(points_[from], points_[to], points_[other]);
    }
    if (best.is_found && cost + moved_[from] >= best.cost) return;
    double nearest = std::numeric_limits<double>::infinity();
    double area = 0;
    for (const uint32_t i : triangles_of_[from]) {
      const Triangle moved = moved_triangle(i, from, to);
      area -= area_of(triangles_[i]);
      if (is_degenerate(moved)) continue;
      area += area_of(moved);
      const dvec3 before = normal_of(triangles_[i]);
      const dvec3 after = normal_of(moved);
      if (!(glm::dot(before, after) >
            least_turn_cosine * glm::length(before) * glm::length(after))) {
        return;
      }
      nearest =
          std::min(nearest, distance_to_triangle(points_[from], points_[moved.corner.x],
                                                 points_[moved.corner.y], points_[moved.corner.z]));
    }
    if (nearest == std::numeric_limits<double>::infinity()) return;  // a corner, or the last one
    if (area_ + area < least_area_) return;
    cost = filled_gap(from, to, std::max(cost, nearest)) + moved_[from];
    if (!best.is_found || cost < best.cost) best = {true, from, to, cost, area};
  }

  Triangle moved_triangle(uint32_t triangle, uint32_t from, uint32_t to) const {
    Triangle moved = triangles_[triangle];
    for (int c = 0; c < 3; ++c) {
      if (moved.corner[c] == from) moved.corner[c] = to;
    }
    return moved;
  }

  /// How far the triangles of `from`, moved to `to`, lie from those as they are, or `gap` if that
  /// is more: they may span what was open, a bay in the rim of a leaf that has two faces.
  double filled_gap(uint32_t from, uint32_t to, double gap) const {
    for (const uint32_t i : triangles_of_[from]) {
      const Triangle moved = moved_triangle(i, from, to);
      if (is_degenerate(moved)) continue;
      const dvec3 a = points_[moved.corner.x];
      const dvec3 b = points_[moved.corner.y];
      const dvec3 c = points_[moved.corner.z];
      for (const dvec3& p : {0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), (a + b + c) / 3.0}) {
        gap = std::max(gap, distance_to_ring(p, from, gap));
      }
    }
    return gap;
  }

  /// To the vertex's triangles, exact where it is more than `enough`.
  double distance_to_ring(dvec3 p, uint32_t vertex, double enough) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const uint32_t i : triangles_of_[vertex]) {
      if (nearest <= enough) break;
      const uvec3 t = triangles_[i].corner;
      nearest =
          std::min(nearest, distance_to_triangle(p, points_[t.x], points_[t.y], points_[t.z]));
    }
    return nearest;
  }

  std::vector<std::vector<uint32_t>> triangles_of_;
  std::vector<std::vector<uint32_t>> border_of_;
  std::vector<Collapse> best_of_;  ///< per vertex
  std::vector<bool> is_stale_;     ///< per vertex: best_of_ is to be found anew
  std::vector<dvec3> points_;
  std::vector<Triangle> triangles_;
  std::vector<double> moved_;  ///< per vertex: how far what went into it lies from it all
  double area_ = 0;
  double least_area_ = 0;
  double covered_ = 0;  ///< area at first, cut-outs left out
  double error_ = 0;
};

}  // namespace

std::vector<ThinLevel> make_levels(const ThinShape& shape) {
  std::vector<std::optional<PieceSimplifier>> pieces(shape.pieces.size());
  std::vector<ThinLevel> levels;
  size_t last = shape.triangles.size();
  for (int i = 0; i < most_levels; ++i) {
    parallel_for(pieces.size(), 16, [&](size_t begin, size_t end) {
      for (size_t p = begin; p < end; ++p) {
        if (!pieces[p]) pieces[p].emplace(shape, shape.pieces[p]);
        if (shape.pieces[p].triangle_count > most_piece_triangles) continue;
        const auto wanted =
            static_cast<size_t>(level_part * static_cast<double>(pieces[p]->triangle_count()));
        while (pieces[p]->triangle_count() > std::max<size_t>(wanted, 1) && pieces[p]->step()) {
        }
      }
    });
    ThinLevel level;
    for (size_t p = 0; p < pieces.size(); ++p) {
      pieces[p]->append(level, shape.pieces[p].is_sheet);
      level.error.push_back(static_cast<float>(pieces[p]->error()));
    }
    if (static_cast<double>(level.triangles.size()) > 0.8 * static_cast<double>(last)) break;
    last = level.triangles.size();
    levels.push_back(std::move(level));
  }
  return levels;
}

}  // namespace relume
