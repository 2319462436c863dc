#include <array>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/math/frame.h"
#include "core/scene/procedural/generators.h"

namespace relume {
namespace {

/// Strands that share one lock, on average; the groom's features are this large.
constexpr uint32_t strands_per_lock = 36;
/// Index of the first lock's random sequence, beyond those of the strands.
constexpr uint64_t lock_stream = uint64_t{1} << 40;
/// How far a strand's tip is drawn to its lock's tip, and how the pull grows along it.
constexpr float lock_pull = 0.62f;

/// Point `index` of `count` spread evenly over the unit sphere (Fibonacci lattice).
vec3 fibonacci_point(uint32_t index, uint32_t count) {
  constexpr double golden_turn = 2.39996322972865332;
  const double y = 1 - (2.0 * index + 1) / count;
  const double across = std::sqrt(std::max(0.0, 1 - y * y));
  const double angle = golden_turn * index;
  return vec3(dvec3(across * std::cos(angle), y, across * std::sin(angle)));
}

/// A smooth field on the sphere that combs the hair: a whorl about an oblique axis, waves of two
/// sizes and gravity. Tangential, of length about 1.
vec3 comb_field(vec3 n) {
  const vec3 axis(0.36f, 0.86f, 0.36f);
  vec3 flow = 0.75f * glm::cross(axis, n);
  flow += vec3(0, -0.45f, 0);
  flow += 0.45f * vec3(std::sin(3.1f * n.y + 1.3f), std::sin(2.7f * n.z + 0.4f),
                       std::sin(3.4f * n.x + 2.6f));
  flow += 0.22f * vec3(std::sin(7.3f * n.z + 0.9f), std::sin(8.1f * n.x + 2.1f),
                       std::sin(7.7f * n.y + 4.0f));
  return flow - n * glm::dot(flow, n);
}

vec3 tangential(const Frame& frame, float angle) {
  return std::cos(angle) * frame.tangent + std::sin(angle) * frame.bitangent;
}

/// A polyline from a root, `segments` steps of equal length, kept outside the ball.
class StrandPath {
 public:
  StrandPath(const HairBallParams& params, float length)
      : ball_radius_(params.ball_radius), step_(length / static_cast<float>(params.segments)) {}

  void start(vec3 root, std::vector<vec3>& points) const { points.assign(1, root); }

  /// Appends a point one step along `direction`, turned away from the ball where it would enter it.
  void advance(vec3 direction, std::vector<vec3>& points) const {
    const vec3 from = points.back();
    vec3 unit = normalize_or(direction, vec3(0, 1, 0));
    const vec3 outward = normalize_or(from, vec3(0, 1, 0));
    const float lift = 0.06f;
    if (glm::length(from + step_ * unit) < ball_radius_ * 1.001f) {
      const vec3 along = unit - outward * glm::dot(unit, outward);
      unit =
          normalize_or(normalize_or(along, make_frame(outward).tangent) + lift * outward, outward);
    }
    points.push_back(from + step_ * unit);
  }

 private:
  float ball_radius_;
  float step_;
};

/// What makes one strand or lock differ from its neighbours.
struct Wave {
  float lean = 0;   ///< how strongly the comb lays the strand down
  float phase = 0;  ///< radians
  float turns = 0;  ///< of the curl along the strand
  vec3 offset{0};   ///< constant change of direction
};

Wave draw_wave(Random& random, vec3 n, float spread) {
  Wave wave;
  const float lean = random.uniform(0.75f, 1.25f);
  const float phase = random.uniform(0, 2 * pi);
  const float turns = random.uniform(0.7f, 1.3f);
  const float angle = random.uniform(0, 2 * pi);
  const float radius = random.uniform();
  wave.lean = lean;
  wave.phase = phase;
  wave.turns = turns;
  wave.offset = spread * std::sqrt(radius) * tangential(make_frame(n), angle);
  return wave;
}

/// The strand that the comb alone would give.
void trace_combed(const HairBallParams& params, vec3 n, float length, const Wave& wave,
                  std::vector<vec3>& points) {
  const StrandPath path(params, length);
  const vec3 flow = comb_field(n);
  const Frame frame = make_frame(n);
  // A helix of amplitude a and w turns moves sideways by 2 pi w a per unit of length.
  const float curl_slope = params.curl * 2 * pi * wave.turns * 0.22f;
  path.start(params.ball_radius * n, points);
  for (int i = 0; i < params.segments; ++i) {
    const float along = (static_cast<float>(i) + 0.5f) / static_cast<float>(params.segments);
    const float angle = wave.phase + 2 * pi * wave.turns * along;
    const vec3 curl = curl_slope * std::sqrt(along) * tangential(frame, angle);
    const vec3 droop = vec3(0, -0.55f, 0) * along * along;
    const float comb = wave.lean * (0.55f + 0.75f * along);
    path.advance(n + comb * flow + wave.offset + curl + droop, points);
  }
}

/// Locks by place: which of the lattice points that root locks is nearest to a direction.
class Locks {
 public:
  explicit Locks(const HairBallParams& params)
      : count_(std::max<uint32_t>(1, params.strands / strands_per_lock)) {
    const float spacing = std::sqrt(4 * pi / static_cast<float>(count_));
    cells_ = std::clamp(static_cast<int>(2.0f / spacing), 1, 256);
    roots_.resize(count_);
    points_.resize(count_);
    first_.assign(static_cast<size_t>(cells_) * cells_ * cells_ + 1, 0);
    order_.resize(count_);
    trace_locks(params);
    fill_grid();
  }

  uint32_t nearest(vec3 n) const {
    uint32_t best = 0;
    float best_distance = std::numeric_limits<float>::infinity();
    const auto cell = cell_of(n);
    for (int reach = 1; best_distance == std::numeric_limits<float>::infinity(); ++reach) {
      for_cells(cell, reach, [&](size_t index) {
        for (uint32_t k = first_[index]; k < first_[index + 1]; ++k) {
          const vec3 difference = roots_[order_[k]] - n;
          const float distance = glm::dot(difference, difference);
          if (distance < best_distance) {
            best_distance = distance;
            best = order_[k];
          }
        }
      });
    }
    return best;
  }

  const std::vector<vec3>& points(uint32_t lock) const { return points_[lock]; }

 private:
  void trace_locks(const HairBallParams& params) {
    parallel_for(count_, 64, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        Random random(params.seed, RandomStream::strands, lock_stream + i);
        const vec3 even = fibonacci_point(static_cast<uint32_t>(i), count_);
        const float angle = random.uniform(0, 2 * pi);
        const float radius =
            random.uniform(0, 0.45f) * std::sqrt(4 * pi / static_cast<float>(count_));
        const vec3 n = normalize_or(even + radius * tangential(make_frame(even), angle), even);
        const float length = random.uniform(0.75f, 1.0f) * params.length_high;
        const Wave wave = draw_wave(random, n, 0.25f);
        roots_[i] = n;
        trace_combed(params, n, length, wave, points_[i]);
      }
    });
  }

  void fill_grid() {
    for (const vec3 root : roots_) ++first_[index_of(cell_of(root)) + 1];
    for (size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
    for (uint32_t i = 0; i < count_; ++i) order_[next[index_of(cell_of(roots_[i]))]++] = i;
  }

  std::array<int, 3> cell_of(vec3 n) const {
    std::array<int, 3> cell{};
    for (size_t c = 0; c < 3; ++c) {
      cell[c] = std::clamp(static_cast<int>(0.5f * (n[c] + 1) * static_cast<float>(cells_)), 0,
                           cells_ - 1);
    }
    return cell;
  }
  size_t index_of(const std::array<int, 3>& cell) const {
    return (static_cast<size_t>(cell[2]) * cells_ + cell[1]) * cells_ + cell[0];
  }

  template <class Visit>
  void for_cells(const std::array<int, 3>& center, int reach, Visit visit) const {
    std::array<int, 3> low{};
    std::array<int, 3> high{};
    for (size_t c = 0; c < 3; ++c) {
      low[c] = std::max(0, center[c] - reach);
      high[c] = std::min(cells_ - 1, center[c] + reach);
    }
    for (int z = low[2]; z <= high[2]; ++z) {
      for (int y = low[1]; y <= high[1]; ++y) {
        for (int x = low[0]; x <= high[0]; ++x) visit(index_of({x, y, z}));
      }
    }
  }

  uint32_t count_;
  int cells_ = 1;
  std::vector<vec3> roots_;                ///< unit
  std::vector<std::vector<vec3>> points_;  ///< segments + 1 each
  std::vector<uint32_t> first_;            ///< per cell, into order_
  std::vector<uint32_t> order_;
};

/// Draws a combed strand towards its lock, more so near the tip, and restores its length.
void pull_to_lock(const HairBallParams& params, const std::vector<vec3>& lock, float length,
                  float pull, std::vector<vec3>& points) {
  const std::vector<vec3> combed = points;
  const vec3 between_roots = combed[0] - lock[0];
  const auto pulled = [&](size_t i) {
    const float along = static_cast<float>(i) / static_cast<float>(params.segments);
    const float weight = pull * along * std::sqrt(along);
    const vec3 beside_lock = lock[i] + (1 - 0.85f * along) * between_roots;
    return combed[i] + weight * (beside_lock - combed[i]);
  };
  const StrandPath path(params, length);
  path.start(combed[0], points);
  for (size_t i = 0; i + 1 < combed.size(); ++i) path.advance(pulled(i + 1) - pulled(i), points);
}

void make_strand(const HairBallParams& params, const Locks& locks, uint32_t strand,
                 Curves& curves) {
  Random random(params.seed, RandomStream::strands, strand);
  const vec3 even = fibonacci_point(strand, params.strands);
  const float angle = random.uniform(0, 2 * pi);
  const float radius =
      random.uniform(0, 0.6f) * std::sqrt(4 * pi / static_cast<float>(params.strands));
  const vec3 n = normalize_or(even + radius * tangential(make_frame(even), angle), even);
  const float length = random.uniform(params.length_low, params.length_high);
  const float pull = lock_pull * random.uniform(0.55f, 1.25f);
  const uint32_t choice = random.below(static_cast<uint32_t>(params.strand_materials.size()));
  const float fly_away = random.uniform();
  const Wave wave = draw_wave(random, n, fly_away < 0.04f ? 0.9f : 0.3f);

  std::vector<vec3> points;
  trace_combed(params, n, length, wave, points);
  pull_to_lock(params, locks.points(locks.nearest(n)), length, fly_away < 0.04f ? 0 : pull, points);

  const size_t first = static_cast<size_t>(strand) * (params.segments + 1);
  for (size_t i = 0; i < points.size(); ++i) {
    const float along = static_cast<float>(i) / static_cast<float>(params.segments);
    const float taper = 1 - along * along * (1 - params.tip_scale);
    curves.points[first + i] = vec4(points[i], params.strand_radius * taper);
  }
  curves.offsets[strand] = static_cast<uint32_t>(first);
  curves.materials[strand] = params.strand_materials[choice];
}

void check_params(const HairBallParams& params) {
  CHECK_MSG(params.strands >= 1 && params.strands <= 10'000'000, "strands {}", params.strands);
  CHECK_MSG(params.segments >= 1 && params.segments <= 256, "segments {}", params.segments);
  CHECK_MSG((static_cast<uint64_t>(params.segments) + 1) * params.strands < (uint64_t{1} << 32),
            "{} strands of {} segments", params.strands, params.segments);
  CHECK_MSG(params.ball_radius > 0 && is_finite(params.ball_radius), "{}", params.ball_radius);
  CHECK_MSG(params.length_low > 0 && params.length_high >= params.length_low &&
                is_finite(params.length_high),
            "length {} to {}", params.length_low, params.length_high);
  CHECK_MSG(params.strand_radius > 0 && is_finite(params.strand_radius), "{}",
            params.strand_radius);
  CHECK_MSG(params.tip_scale > 0 && params.tip_scale <= 1, "tip scale {}", params.tip_scale);
  CHECK_MSG(params.curl >= 0 && params.curl <= 1, "curl {}", params.curl);
  CHECK(!params.strand_materials.empty());
}

}  // namespace

Prototype make_hair_ball(const HairBallParams& params) {
  check_params(params);
  const Locks locks(params);
  const size_t points_per_strand = static_cast<size_t>(params.segments) + 1;
  Curves curves;
  curves.points.resize(points_per_strand * params.strands);
  curves.offsets.resize(static_cast<size_t>(params.strands) + 1);
  curves.materials.resize(params.strands);
  parallel_for(params.strands, 256, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      make_strand(params, locks, static_cast<uint32_t>(i), curves);
    }
  });
  curves.offsets.back() = static_cast<uint32_t>(curves.points.size());

  // A little inside, so that no root sinks into a facet of the skin.
  SphereParams skin;
  skin.radius = 0.998f * params.ball_radius;
  skin.material = params.ball_material;
  Prototype prototype;
  prototype.name = "hair-ball";
  prototype.shapes.emplace_back(make_sphere(skin));
  prototype.shapes.emplace_back(std::move(curves));
  return prototype;
}

}  // namespace relume
