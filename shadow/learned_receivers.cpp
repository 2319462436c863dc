#include "shadow/learned_receivers.h"

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace relume {
namespace {

/// Cosine of view angles below which a cell on a surface is stretched no further.
constexpr double least_view_cosine = 0.1;
/// Part of a footprint's size by which its own surface may rise above its plane.
constexpr double surface_slack = 0.02;
/// Radii of spots.
constexpr double strand_spot_px = 0.5;
constexpr double surface_spot_px = 1;
constexpr float surface_margin = 1;

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

  /// Adds the cell at `position` to a covariance.
  void add_cell(dvec3 position, dvec3 normal, std::array<double, 6>& covariance) const {
    const dvec3 offset = position - eye;
    const double side = cell * std::max(glm::dot(offset, forward), 0.0);
    dvec3 axes[2] = {right, up};
    const double distance = glm::length(offset);
    if (glm::dot(normal, normal) > 0 && distance > 0) {
      const dvec3 wo = -offset / distance;
      const double facing = glm::dot(normal, wo);
      const double cosine = std::copysign(std::max(std::abs(facing), least_view_cosine), facing);
      for (dvec3& axis : axes) axis -= wo * (glm::dot(normal, axis) / cosine);
    }
    for (const dvec3& a : axes) {
      const double variance = side * side / 12;
      const std::array<double, 6> squares = {a.x * a.x, a.x * a.y, a.x * a.z,
                                             a.y * a.y, a.y * a.z, a.z * a.z};
      for (size_t i = 0; i < squares.size(); ++i) covariance[i] += variance * squares[i];
    }
  }
};

/// Some of a receiver's samples, close to each other.
struct Spot {
  dvec3 anchor{0};  ///< the first one
  dvec3 sum{0};     ///< of offsets from it
  std::array<double, 6> squares{};
  dvec3 normal{0};
  int samples = 0;

  void add(dvec3 position, dvec3 n) {
    const dvec3 d = position - anchor;
    sum += d;
    const std::array<double, 6> products = {d.x * d.x, d.x * d.y, d.x * d.z,
                                            d.y * d.y, d.y * d.z, d.z * d.z};
    for (size_t i = 0; i < products.size(); ++i) squares[i] += products[i];
    normal += n;
    ++samples;
  }
};

/// A spot as mean and covariance.
struct Extent {
  dvec3 mean;
  std::array<double, 6> covariance;
  dvec3 normal;
  double share;
};

Extent extent_of(const Spot& spot, int samples) {
  const double inverse = 1.0 / spot.samples;
  const dvec3 m = spot.sum * inverse;
  const std::array<double, 6> products = {m.x * m.x, m.x * m.y, m.x * m.z,
                                          m.y * m.y, m.y * m.z, m.z * m.z};
  Extent extent{spot.anchor + m, {}, spot.normal, spot.samples / static_cast<double>(samples)};
  for (size_t i = 0; i < products.size(); ++i) {
    extent.covariance[i] = spot.squares[i] * inverse - products[i];
  }
  // Rounding must not leave negative variances.
  for (const size_t i : {0, 3, 5}) extent.covariance[i] = std::max(extent.covariance[i], 0.0);
  const double length = glm::length(extent.normal);
  if (length > 0) extent.normal /= length;
  return extent;
}

/// Takes the receivers of a group apart.
class SpotFinder {
 public:
  explicit SpotFinder(const CellCamera& camera) : camera_(camera) {}

  /// The spots of lane `lane`, whose stored members start at `members`.
  const std::vector<Extent>& find(const ReceiverGroup& group, int lane, const Member* members) {
    const Receivers& r = group.receivers;
    const Footprint& footprint = group.footprints[lane];
    const dvec3 anchor(r.position[0][lane], r.position[1][lane], r.position[2][lane]);
    dvec3 normal(0);
    if (r.normal[0] != nullptr) normal = {r.normal[0][lane], r.normal[1][lane], r.normal[2][lane]};
    extents_.clear();
    if (footprint.stored_members < 2) {
      Extent& extent = extents_.emplace_back();
      extent.mean = anchor + dvec3(footprint.offset);
      for (size_t i = 0; i < 6; ++i) {
        extent.covariance[i] = static_cast<double>(footprint.covariance[i]);
      }
      extent.normal = normal;
      extent.share = 1;
      return extents_;
    }
    spots_.clear();
    for (int m = 0; m < footprint.stored_members; ++m) {
      add(anchor + dvec3(members[m].offset), dvec3(members[m].normal));
    }
    for (const Spot& spot : spots_) {
      extents_.push_back(extent_of(spot, footprint.stored_members));
    }
    return extents_;
  }

 private:
  void add(dvec3 position, dvec3 normal) {
    const bool on_strand = normal == dvec3(0);
    const double radius =
        (on_strand ? strand_spot_px : surface_spot_px) * camera_.pixel_at(position);
    for (Spot& spot : spots_) {
      const dvec3 d = position - spot.anchor;
      const double length = glm::length(spot.normal) * glm::length(normal);
      if (glm::dot(d, d) < radius * radius && !(glm::dot(spot.normal, normal) < 0.5 * length)) {
        spot.add(position, normal);
        return;
      }
    }
    spots_.emplace_back().anchor = position;
    spots_.back().add(position, normal);
  }

  const CellCamera& camera_;
  std::vector<Spot> spots_;
  std::vector<Extent> extents_;
};

/// Calls visit(group, lane, extent) for each spot of a tile.
template <class Visit>
void for_each_spot(const ViewReceivers& view, size_t tile, SpotFinder& finder, const Visit& visit) {
  view.visit_tile(tile, [&](const ReceiverGroup& group) {
    const Member* members = group.members.data();
    for (int lane = 0; lane < group.receivers.count; ++lane) {
      if (group.receivers.weight[lane] > 0) {
        for (const Extent& extent : finder.find(group, lane, members)) visit(group, lane, extent);
      }
      members += group.footprints[lane].stored_members;
    }
  });
}

/// What a tile holds, before there is room for it.
struct TileCount {
  size_t spots = 0;
  dvec3 low{std::numeric_limits<double>::infinity()};
  dvec3 high{-std::numeric_limits<double>::infinity()};
};

TileCount count_tile(const ViewReceivers& view, size_t tile, SpotFinder& finder) {
  TileCount count;
  for_each_spot(view, tile, finder, [&](const ReceiverGroup&, int, const Extent& extent) {
    count.low = glm::min(count.low, extent.mean);
    count.high = glm::max(count.high, extent.mean);
    ++count.spots;
  });
  return count;
}

void learn_spot(const ReceiverGroup& group, int lane, const Extent& extent,
                const CellCamera& camera, size_t out, LearnedReceivers& learned) {
  const Receivers& receivers = group.receivers;
  const bool on_surface = receivers.normal[0] != nullptr;
  std::array<double, 6> covariance = extent.covariance;
  camera.add_cell(extent.mean, extent.normal, covariance);
  const double inverse = 1 / learned.scale;
  const dvec3 p = (extent.mean - learned.center) * inverse;
  for (size_t axis = 0; axis < 3; ++axis) {
    learned.position[axis][out] = static_cast<float>(p[axis]);
    learned.normal[axis][out] = static_cast<float>(extent.normal[axis]);
  }
  for (size_t i = 0; i < 6; ++i) {
    learned.covariance[i][out] = static_cast<float>(covariance[i] * inverse * inverse);
  }
  const double size = std::sqrt(covariance[0] + covariance[3] + covariance[5]);
  const auto bias = static_cast<double>(receivers.bias[lane]);
  learned.bias[out] =
      static_cast<float>((on_surface ? 4 * bias + surface_slack * size : bias) * inverse);
  learned.margin[out] = on_surface ? surface_margin : 0.0f;
  learned.one_sided[out] = on_surface && !receivers.lit_from_behind ? 1 : 0;
  learned.share[out] = static_cast<float>(extent.share);
  learned.index[out] = static_cast<uint32_t>(receivers.first) + static_cast<uint32_t>(lane);
}

void make_room(LearnedReceivers& learned, size_t count) {
  for (auto& array : learned.position) array.resize(count);
  for (auto& array : learned.normal) array.resize(count);
  for (auto& array : learned.covariance) array.resize(count);
  learned.bias.resize(count);
  learned.margin.resize(count);
  learned.one_sided.resize(count);
  learned.share.resize(count);
  learned.index.resize(count);
}

}  // namespace

LearnedReceivers learn_receivers(const ViewReceivers& view) {
  CHECK_MSG(view.count() < uint64_t{1} << 32, "{} receivers", view.count());
  const size_t tiles = view.tile_count();
  const CellCamera camera(view.info());
  std::vector<TileCount> counts(tiles);
  parallel_for(tiles, 4, [&](size_t begin, size_t end) {
    SpotFinder finder(camera);
    for (size_t t = begin; t < end; ++t) counts[t] = count_tile(view, t, finder);
  });
  LearnedReceivers learned;
  TileCount all;
  for (const TileCount& count : counts) {
    learned.tile_first.push_back(all.spots);
    all.spots += count.spots;
    all.low = glm::min(all.low, count.low);
    all.high = glm::max(all.high, count.high);
  }
  learned.tile_first.push_back(all.spots);
  if (all.spots > 0) {
    learned.center = 0.5 * (all.low + all.high);
    const double radius = 0.5 * glm::length(all.high - all.low);
    // A single point: any length near its own.
    const double least = 1e-6 * std::max(glm::length(learned.center), 1e-20);
    learned.scale = std::max(radius, least);
  }
  make_room(learned, all.spots);
  parallel_for(tiles, 4, [&](size_t begin, size_t end) {
    SpotFinder finder(camera);
    for (size_t t = begin; t < end; ++t) {
      size_t out = learned.tile_first[t];
      for_each_spot(view, t, finder,
                    [&](const ReceiverGroup& group, int lane, const Extent& extent) {
                      learn_spot(group, lane, extent, camera, out++, learned);
                    });
    }
  });
  return learned;
}

}  // namespace relume
