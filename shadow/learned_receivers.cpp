#include "shadow/learned_receivers.h"

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/trace/ray_bias.h"

namespace relume {
namespace {

/// Cosine of view angles below which a cell on a surface is stretched no further; on strands, sine
/// of the angle between strand and line of sight.
constexpr double least_view_cosine = 0.1;
/// Strands that are narrower than a cell by more count as so narrow.
constexpr double most_narrow = 5;
/// Part of a footprint's size by which its own surface may rise above its plane.
constexpr double surface_slack = 0.02;
/// Radii of spots.
constexpr double strand_spot_px = 0.5;
constexpr double surface_spot_px = 0.3;
constexpr float surface_margin = 1;
/// A sample within so many pixels of a spot's plane, and this cosine of its normal, is on the same
/// surface.
constexpr double plane_distance_px = 0.05;
constexpr double plane_cosine = 0.98;
/// Least cosine between the normals of samples of a piece that are one spot.
constexpr double piece_cosine = 0.9;
/// How far from a sample its own surface is looked for.
constexpr double search_px = 0.5;
/// Bodies are looked for so deep.
constexpr double body_px = 1;

dvec3 normalize_or_zero(dvec3 v) {
  const double length = glm::length(v);
  return length > 0 ? v / length : dvec3(0);
}

std::array<double, 6> squares_of(dvec3 d) {
  return {d.x * d.x, d.x * d.y, d.x * d.z, d.y * d.y, d.y * d.z, d.z * d.z};
}

/// The camera as far as cells need it.
struct CellCamera {
  dvec3 eye;
  dvec3 forward;
  dvec3 right;
  dvec3 up;
  double pixel;  ///< side of a pixel at unit depth
  double cell;   ///< and of a sample's cell

  explicit CellCamera(const CacheInfo& info) : eye(info.camera.eye) {
    forward = glm::normalize(dvec3(info.camera.target) - eye);
    const dvec3 any = std::abs(forward.x) < 0.5 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
    right = glm::cross(forward, dvec3(info.camera.up));
    if (!(glm::length(right) > 1e-6)) right = glm::cross(forward, any);
    right = glm::normalize(right);
    up = glm::cross(right, forward);
    const double fov = static_cast<double>(radians_from_degrees(info.camera.fov_y_deg));
    pixel = 2 * std::tan(0.5 * fov) / info.height;
    cell = pixel / std::sqrt(std::max(1, info.spp));
  }

  double pixel_at(dvec3 position) const {
    return pixel * std::max(glm::dot(position - eye, forward), 0.0);
  }

  double cell_at(dvec3 position) const {
    return cell * std::max(glm::dot(position - eye, forward), 0.0);
  }

  /// Adds the cell at `position` to a covariance.
  void add_cell(dvec3 position, dvec3 normal, std::array<double, 6>& covariance) const {
    const dvec3 offset = position - eye;
    dvec3 axes[2] = {right, up};
    const double distance = glm::length(offset);
    if (glm::dot(normal, normal) > 0 && distance > 0) {
      const dvec3 wo = -offset / distance;
      const double facing = glm::dot(normal, wo);
      const double cosine = std::copysign(std::max(std::abs(facing), least_view_cosine), facing);
      for (dvec3& axis : axes) axis -= wo * (glm::dot(normal, axis) / cosine);
    }
    const double side = cell_at(position);
    for (const dvec3& axis : axes) add_spread(side * axis, covariance);
  }

  /// Adds the part of a strand at `position` that a sample stands for to a covariance: as long as
  /// its cell shows of it, or where it is narrower, as a piece with the cell's area. Across it
  /// there is nothing: samples on a strand lie on its axis.
  void add_strand_cell(dvec3 position, dvec3 tangent, double width,
                       std::array<double, 6>& covariance) const {
    const double side = cell_at(position);
    const double sine = glm::length(glm::cross(normalize_or_zero(position - eye), tangent));
    const double narrow = std::clamp(side / std::max(width, 1e-300), 1.0, most_narrow);
    add_spread(narrow * side / std::max(sine, least_view_cosine) * tangent, covariance);
  }

 private:
  /// Points evenly spread along `axis`.
  static void add_spread(dvec3 axis, std::array<double, 6>& covariance) {
    const std::array<double, 6> squares = squares_of(axis);
    for (size_t i = 0; i < squares.size(); ++i) covariance[i] += squares[i] / 12;
  }
};

/// Samples as mean and covariance.
struct Extent {
  dvec3 mean{0};
  std::array<double, 6> covariance{};
  dvec3 normal{0};  ///< zero on strands
  double samples = 1;
};

/// Adds the samples of `b` to those of `a`.
void merge(Extent& a, const Extent& b) {
  const double samples = a.samples + b.samples;
  const double part = b.samples / samples;
  const dvec3 step = b.mean - a.mean;
  const std::array<double, 6> between = squares_of(step);
  for (size_t i = 0; i < between.size(); ++i) {
    a.covariance[i] =
        (1 - part) * a.covariance[i] + part * b.covariance[i] + part * (1 - part) * between[i];
  }
  a.mean += part * step;
  a.normal = normalize_or_zero((1 - part) * a.normal + part * b.normal);
  a.samples = samples;
}

/// A spot of a pixel and the surface that it lies on.
struct Spot {
  Extent extent;
  dvec3 anchor{0};         ///< its first sample
  dvec3 anchor_normal{0};  ///< as the light judges it
  dvec3 plane_normal{0};   ///< of the geometry, towards the eye; zero on strands
  dvec3 tangent{0};        ///< of the strand; zero on surfaces and where it was not found
  uint32_t piece = no_piece;
  uint32_t receiver = 0;  ///< its first one
  double bias = 0;
  bool lit_from_behind = false;
  bool has_back = false;  ///< light from behind would leave through another face of its piece
};

/// Learns a tile.
class TileLearner {
 public:
  TileLearner(const Tracer& tracer, const ThinGeometry& geometry, const CellCamera& camera,
              LearnedReceivers& out)
      : tracer_(tracer), geometry_(geometry), camera_(camera), out_(out) {}

  void add(const ReceiverGroup& group) {
    if (group.slot == 0) finish();
    share_ = group.share;
    const Member* members = group.members.data();
    for (int lane = 0; lane < group.receivers.count; ++lane) {
      if (group.receivers.weight[lane] > 0) add(group, lane, members);
      members += group.footprints[lane].stored_members;
    }
  }

  /// Writes out the spots of the last sixteen pixels; they can grow no more.
  void finish() {
    std::array<uint32_t, block_lanes> first{};
    for (size_t lane = 0; lane < block_lanes; ++lane) {
      first[lane] = static_cast<uint32_t>(out_.spots.size());
      for (const Spot& spot : pixels_[lane]) write(spot);
      pixels_[lane].clear();
    }
    for (const Link& link : links_) {
      out_.links.push_back({link.receiver, first[link.lane] + link.spot, link.share});
    }
    links_.clear();
    out_.tile_spots.resize(1);
    out_.tile_links.resize(1);
    LearnedReceivers::Range& spots = out_.tile_spots.front();
    LearnedReceivers::Range& links = out_.tile_links.front();
    spots.all_end = out_.spots.size();
    links.all_end = out_.links.size();
    if (share_ == PixelShare::all) return;
    spots.quarter_end = spots.all_end;
    links.quarter_end = links.all_end;
  }

 private:
  struct Link {
    uint32_t receiver;
    uint32_t lane;
    uint32_t spot;  ///< of its pixel
    float share;
  };

  void add(const ReceiverGroup& group, int lane, const Member* members) {
    const Receivers& r = group.receivers;
    const Footprint& footprint = group.footprints[lane];
    const bool on_surface = r.normal[0] != nullptr;
    first_link_ = links_.size();
    Spot spot;
    spot.receiver = static_cast<uint32_t>(r.first) + static_cast<uint32_t>(lane);
    spot.bias = static_cast<double>(r.bias[lane]);
    spot.lit_from_behind = r.lit_from_behind;
    const dvec3 anchor(r.position[0][lane], r.position[1][lane], r.position[2][lane]);
    if (footprint.stored_members < 2) {
      spot.anchor = anchor;
      if (on_surface) {
        spot.extent.normal = {r.normal[0][lane], r.normal[1][lane], r.normal[2][lane]};
      }
      spot.extent.mean = anchor;
      const double radius =
          (on_surface ? surface_spot_px : strand_spot_px) * camera_.pixel_at(anchor);
      const auto& c = footprint.covariance;
      if (static_cast<double>(c[0] + c[3] + c[5]) <= radius * radius) {
        spot.extent.mean += dvec3(footprint.offset);
        for (size_t i = 0; i < 6; ++i) spot.extent.covariance[i] = static_cast<double>(c[i]);
      }
      place(spot, on_surface, lane, 1);
      return;
    }
    const float share = 1 / static_cast<float>(footprint.stored_members);
    for (int m = 0; m < footprint.stored_members; ++m) {
      spot.anchor = anchor + dvec3(members[m].offset);
      spot.extent.mean = spot.anchor;
      spot.extent.normal = dvec3(members[m].normal);
      place(spot, on_surface, lane, share);
    }
  }

  /// Adds `spot` to one of its pixel's or as a new one.
  void place(Spot& spot, bool on_surface, int lane, float share) {
    std::vector<Spot>& spots = pixels_[static_cast<size_t>(lane)];
    spot.anchor_normal = spot.extent.normal;
    spot.plane_normal = spot.extent.normal;
    spot.piece = no_piece;
    const double pixel = camera_.pixel_at(spot.anchor);
    uint32_t i = 0;
    while (i < spots.size() && !(on_surface ? is_in_plane(spots[i], spot, pixel)
                                            : is_on_strand(spots[i], spot, pixel))) {
      ++i;
    }
    if (on_surface && i == spots.size()) {
      find_surface(spot, pixel);
      i = 0;
      while (i < spots.size() && !is_on_piece(spots[i], spot, pixel)) ++i;
    }
    if (i == spots.size()) {
      if (!on_surface) find_strand(spot);
      spot.has_back = on_surface && spot.lit_from_behind && has_back(spot, pixel);
      spots.push_back(spot);
    } else {
      merge(spots[i].extent, spot.extent);
      spots[i].bias = std::max(spots[i].bias, spot.bias);
    }
    for (size_t l = first_link_; l < links_.size(); ++l) {
      if (links_[l].spot != i) continue;
      links_[l].share += share;
      return;
    }
    links_.push_back({spot.receiver, static_cast<uint32_t>(lane), i, share});
  }

  static bool is_on_strand(const Spot& spot, const Spot& sample, double pixel) {
    return spot.receiver == sample.receiver &&
           glm::distance(spot.anchor, sample.anchor) < strand_spot_px * pixel;
  }

  /// So near the spot's plane that it can only be the same surface.
  static bool is_in_plane(const Spot& spot, const Spot& sample, double pixel) {
    const dvec3 step = sample.anchor - spot.anchor;
    return glm::dot(spot.anchor_normal, sample.anchor_normal) > plane_cosine &&
           std::abs(glm::dot(step, spot.plane_normal)) < plane_distance_px * pixel &&
           glm::dot(step, step) < surface_spot_px * surface_spot_px * pixel * pixel;
  }

  static bool is_on_piece(const Spot& spot, const Spot& sample, double pixel) {
    const dvec3 step = sample.anchor - spot.anchor;
    return spot.piece != no_piece && spot.piece == sample.piece &&
           glm::dot(spot.anchor_normal, sample.anchor_normal) > piece_cosine &&
           glm::dot(step, step) < surface_spot_px * surface_spot_px * pixel * pixel;
  }

  /// Looks for the surface along the line of sight.
  void find_surface(Spot& spot, double pixel) const {
    const dvec3 offset = spot.anchor - camera_.eye;
    const double distance = glm::length(offset);
    const double reach = search_px * pixel;
    if (!(distance > reach)) return;
    const dvec3 sight = offset / distance;
    const std::optional<SurfacePoint> point = tracer_.intersect(
        {vec3(spot.anchor - reach * sight), 0, vec3(sight), static_cast<float>(2 * reach)});
    if (!point || point->geometric_normal == vec3(0)) return;
    spot.plane_normal = dvec3(point->geometric_normal);
    spot.piece = geometry_.piece_at(tracer_.scene(), *point);
  }

  /// Looks for the strand along the line of sight. The tracer leaves out a strand's diameter after
  /// a ray's start.
  void find_strand(Spot& spot) const {
    spot.tangent = dvec3(0);
    const dvec3 offset = spot.anchor - camera_.eye;
    const double distance = glm::length(offset);
    const double reach = 2 * spot.bias;
    if (!(distance > reach)) return;
    const dvec3 sight = offset / distance;
    const std::optional<SurfacePoint> point = tracer_.intersect(
        {vec3(spot.anchor - reach * sight), 0, vec3(sight), static_cast<float>(2 * reach)});
    if (point && point->geometric_normal == vec3(0)) spot.tangent = dvec3(point->tangent);
  }

  /// Whether a ray from the spot into its surface, as a light from behind would have it, soon
  /// meets its piece again.
  bool has_back(const Spot& spot, double pixel) const {
    if (spot.piece == no_piece) return false;
    const vec3 normal(spot.plane_normal);
    const Ray ray = make_shadow_ray(vec3(spot.anchor), &normal, static_cast<float>(spot.bias),
                                    -normal, static_cast<float>(body_px * pixel));
    const std::optional<SurfacePoint> point = tracer_.intersect(ray);
    return point && geometry_.piece_at(tracer_.scene(), *point) == spot.piece;
  }

  void write(const Spot& spot) {
    const bool on_surface = spot.plane_normal != dvec3(0);
    std::array<double, 6> covariance = spot.extent.covariance;
    // The spread of a strand, of which there are few samples, by theirs.
    if (!on_surface && spot.extent.samples > 1) {
      for (double& c : covariance) c *= spot.extent.samples / (spot.extent.samples - 1);
    }
    // Rounding must not leave negative variances.
    for (const size_t i : {0, 3, 5}) covariance[i] = std::max(covariance[i], 0.0);
    if (spot.tangent != dvec3(0)) {
      camera_.add_strand_cell(spot.extent.mean, spot.tangent, spot.bias, covariance);
    } else {
      camera_.add_cell(spot.extent.mean, spot.plane_normal, covariance);
    }
    const double inverse = 1 / out_.scale;
    // Onto the surface at its first sample: the mean of a bent surface's samples lies beside it.
    const dvec3 off =
        glm::dot(spot.extent.mean - spot.anchor, spot.plane_normal) * spot.plane_normal;
    const dvec3 p = (spot.extent.mean - off - out_.center) * inverse;
    CoverageReceiver& learned = out_.spots.emplace_back();
    for (size_t axis = 0; axis < 3; ++axis) {
      learned.position[axis] = static_cast<float>(p[axis]);
      learned.normal[axis] = static_cast<int16_t>(std::lround(32767 * spot.anchor_normal[axis]));
      learned.plane[axis] = static_cast<int16_t>(std::lround(32767 * spot.plane_normal[axis]));
    }
    for (size_t i = 0; i < 6; ++i) {
      learned.covariance[i] = static_cast<float>(covariance[i] * inverse * inverse);
    }
    const double size = std::sqrt(covariance[0] + covariance[3] + covariance[5]);
    learned.bias = static_cast<float>(
        (on_surface ? 4 * spot.bias + surface_slack * size : spot.bias) * inverse);
    learned.margin = on_surface ? surface_margin : 0.0f;
    learned.piece = spot.piece != no_piece ? piece_tag(spot.piece) : -1.0f;
    learned.lit_from_behind = spot.lit_from_behind ? 1 : 0;
    learned.has_back = spot.has_back ? 1 : 0;
  }

  const Tracer& tracer_;
  const ThinGeometry& geometry_;
  const CellCamera& camera_;
  LearnedReceivers& out_;
  std::array<std::vector<Spot>, block_lanes> pixels_;
  std::vector<Link> links_;
  size_t first_link_ = 0;                   ///< of the receiver that is being added
  PixelShare share_ = PixelShare::quarter;  ///< the first that holds the pixels that are learned
};

/// Bounds of the receivers' means, tile by tile and all together.
Bounds find_bounds(const ViewReceivers& view) {
  std::vector<Bounds> boxes(view.tile_count());
  parallel_for(boxes.size(), 4, [&](size_t begin, size_t end) {
    for (size_t tile = begin; tile < end; ++tile) {
      view.visit_tile(tile, [&](const ReceiverGroup& group) {
        const Receivers& r = group.receivers;
        for (int i = 0; i < r.count; ++i) {
          if (!(r.weight[i] > 0)) continue;
          boxes[tile].extend(vec3(r.position[0][i], r.position[1][i], r.position[2][i]) +
                             group.footprints[i].offset);
        }
      });
    }
  });
  Bounds all;
  for (const Bounds& box : boxes) all.extend(box);
  return all;
}

LearnedReceivers::Range moved(const LearnedReceivers::Range& range, size_t by) {
  return {range.first + by, range.quarter_end + by, range.all_end + by};
}

/// Moves the tiles' parts to one.
void join(const std::vector<LearnedReceivers>& tiles, LearnedReceivers& learned) {
  size_t spots = 0;
  size_t links = 0;
  for (const LearnedReceivers& tile : tiles) {
    learned.tile_spots.push_back(moved(tile.tile_spots.front(), spots));
    learned.tile_links.push_back(moved(tile.tile_links.front(), links));
    spots += tile.spots.size();
    links += tile.links.size();
  }
  CHECK_MSG(spots < uint64_t{1} << 32, "{} spots", spots);
  learned.spots.resize(spots);
  learned.links.resize(links);
  parallel_for(tiles.size(), 16, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      const size_t first = learned.tile_spots[t].first;
      std::ranges::copy(tiles[t].spots, learned.spots.begin() + static_cast<ptrdiff_t>(first));
      size_t out = learned.tile_links[t].first;
      for (ReceiverLink link : tiles[t].links) {
        link.spot += static_cast<uint32_t>(first);
        learned.links[out++] = link;
      }
    }
  });
}

float find_mean_size(std::span<const CoverageReceiver> spots) {
  double sum = 0;
  for (const CoverageReceiver& spot : spots) {
    const float* c = spot.covariance;
    sum += static_cast<double>(std::sqrt(3 * (c[0] + c[3] + c[5])));
  }
  return static_cast<float>(sum / static_cast<double>(std::max<size_t>(1, spots.size())));
}

}  // namespace

LearnedReceivers learn_receivers(const ViewReceivers& view, const Tracer& tracer,
                                 const ThinGeometry& geometry) {
  CHECK_MSG(view.count() < uint64_t{1} << 32, "{} receivers", view.count());
  LearnedReceivers learned;
  const Bounds bounds = find_bounds(view);
  if (!bounds.empty()) {
    learned.center = dvec3(bounds.center());
    // A single point: any length near its own.
    const double least = 1e-6 * std::max(glm::length(learned.center), 1e-20);
    learned.scale = std::max(static_cast<double>(bounds.radius()), least);
  }
  const CellCamera camera(view.info());
  std::vector<LearnedReceivers> tiles(view.tile_count());
  parallel_for(tiles.size(), 4, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      tiles[t].center = learned.center;
      tiles[t].scale = learned.scale;
      TileLearner learner(tracer, geometry, camera, tiles[t]);
      view.visit_tile(t, [&](const ReceiverGroup& group) { learner.add(group); });
      learner.finish();
    }
  });
  join(tiles, learned);
  learned.mean_size = find_mean_size(learned.spots);
  return learned;
}

}  // namespace relume
