#include "core/scene/io/hair_file.h"

#include <fmt/format.h>

#include <cstring>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/mapped_file.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

// Cem Yuksel, "HAIR file format": a header of 128 bytes, then the arrays that its bits name, in
// this order: segments per strand (u16), points (3 f32), thickness, transparency (f32), colour (3
// f32), the last three per point. Little-endian.
constexpr uint64_t header_bytes = 128;

enum ArrayBits : uint32_t {
  segments_bit = 1,
  points_bit = 2,
  thickness_bit = 4,
  transparency_bit = 8,
  colors_bit = 16,
  all_bits = 31,
};

struct Header {
  char magic[4];
  uint32_t strands;
  uint32_t points;
  uint32_t arrays;
  uint32_t segments;  ///< per strand, where the file has no segments array
  float thickness;    ///< where it has no thickness array
  float transparency;
  float color[3];
  char info[88];
};
static_assert(sizeof(Header) == header_bytes);

RareEvent dropped_segments(".hair segments of zero length dropped");
RareEvent dropped_strands(".hair strands of fewer than two points or no thickness dropped");
RareEvent raised_thickness(".hair thickness of zero raised");
RareEvent clamped_colors(".hair colours clamped to [0, 1]");

class HairReader {
 public:
  HairReader(std::span<const std::byte> bytes, std::string file, const HairOptions& options)
      : bytes_(bytes), file_(std::move(file)), options_(options) {}

  Curves read() {
    read_header();
    lay_out();
    count_points();
    const bool colored = options_.use_colors && (header_.arrays & colors_bit) != 0;
    curves_.offsets.push_back(0);
    curves_.points.reserve(header_.points);
    uint64_t first = 0;
    for (uint32_t strand = 0; strand < header_.strands; ++strand) {
      const uint64_t points = segments_of(strand) + uint64_t{1};
      if (add_strand(first, points)) {
        curves_.materials.push_back(options_.material);
        if (colored) curves_.colors.push_back(mean_color(first, points));
      }
      first += points;
    }
    if (curves_.materials.empty()) {
      throw input_error(file_, "holds no strand of two points and some thickness",
                        "check the file");
    }
    return std::move(curves_);
  }

 private:
  [[noreturn]] void fail(uint64_t byte, std::string_view what, std::string_view mend) const {
    throw input_error(fmt::format("{}: byte {}", file_, byte), what, mend);
  }

  void read_header() {
    if (bytes_.size() < header_bytes) {
      fail(bytes_.size(), "ends inside the 128-byte header", "get the whole file");
    }
    std::memcpy(&header_, bytes_.data(), header_bytes);
    if (std::memcmp(header_.magic, "HAIR", 4) != 0) {
      fail(0, "does not start with \"HAIR\"", "give a file in Cem Yuksel's HAIR format");
    }
    if ((header_.arrays & points_bit) == 0)
      fail(12, "has no points array", "export it with points");
    if ((header_.arrays & ~uint32_t{all_bits}) != 0) {
      fail(12, fmt::format("unknown arrays in bits {:#x}", header_.arrays), "check the file");
    }
    if (header_.strands == 0) fail(4, "holds no strands", "check the file");
    if (header_.strands > max_strands) {
      throw limit_error(file_, fmt::format("{} strands are too many", header_.strands),
                        fmt::format("the limit is {}", max_strands));
    }
    const bool has_thickness = (header_.arrays & thickness_bit) != 0;
    if (!has_thickness && !(header_.thickness > 0 && header_.thickness <= max_coordinate)) {
      fail(20, "the default thickness is not above 0", "give each point a thickness");
    }
  }

  /// Where each array starts; checks that together they fill the file.
  void lay_out() {
    const uint64_t points = header_.points;
    const auto take = [&](uint32_t bit, uint64_t count, uint64_t item_bytes) {
      const uint64_t at = end_;
      if ((header_.arrays & bit) != 0) end_ += count * item_bytes;
      return at;
    };
    segments_at_ = take(segments_bit, header_.strands, 2);
    points_at_ = take(points_bit, points, 12);
    thickness_at_ = take(thickness_bit, points, 4);
    take(transparency_bit, points, 4);
    colors_at_ = take(colors_bit, points, 12);
    if (bytes_.size() == end_) return;
    fail(bytes_.size(),
         fmt::format("{} strands and {} points make {} bytes, the file has {}", header_.strands,
                     points, end_, bytes_.size()),
         bytes_.size() < end_ ? "it is cut short: get the whole file" : "its counts are wrong");
  }

  void count_points() const {
    uint64_t points = 0;
    for (uint32_t strand = 0; strand < header_.strands; ++strand) points += segments_of(strand) + 1;
    if (points == header_.points) return;
    fail(8,
         fmt::format("its strands have {} points together, the header says {}", points,
                     header_.points),
         "the counts are wrong: export it again");
  }

  uint64_t segments_of(uint32_t strand) const {
    if ((header_.arrays & segments_bit) == 0) return header_.segments;
    uint16_t segments = 0;
    std::memcpy(&segments, bytes_.data() + segments_at_ + uint64_t{strand} * 2, 2);
    return segments;
  }

  float number(uint64_t byte) const {
    float value = 0;
    std::memcpy(&value, bytes_.data() + byte, 4);
    return value;
  }

  vec3 vector(uint64_t byte) const { return {number(byte), number(byte + 4), number(byte + 8)}; }

  /// The diameter at a point.
  float thickness(uint64_t point) const {
    if ((header_.arrays & thickness_bit) == 0) return header_.thickness;
    const uint64_t byte = thickness_at_ + point * 4;
    const float value = number(byte);
    if (!(value >= 0 && value <= max_coordinate)) {
      fail(byte, fmt::format("point {} has thickness {}", point, value), "give a number >= 0");
    }
    return value;
  }

  /// Appends a strand without its zero-length segments; false when too little of it is left.
  bool add_strand(uint64_t first, uint64_t points) {
    const size_t begin = curves_.points.size();
    float largest = 0;
    for (uint64_t i = first; i < first + points; ++i) {
      const uint64_t byte = points_at_ + i * 12;
      const vec3 p = vector(byte);
      if (!is_coordinate(p)) {
        fail(byte, fmt::format("point {} is not finite or above 1e9", i), "mend the point");
      }
      const float radius = 0.5f * thickness(i) * options_.thickness_scale;
      largest = std::max(largest, radius);
      if (curves_.points.size() > begin && vec3(curves_.points.back()) == p) {
        dropped_segments.add();
        continue;
      }
      curves_.points.emplace_back(p, radius);
    }
    // A tip may taper to nothing; a strand of ours may not.
    const float smallest = 0.01f * largest;
    if (curves_.points.size() < begin + 2 || !(smallest > 0)) {
      curves_.points.resize(begin);
      dropped_strands.add();
      return false;
    }
    for (size_t i = begin; i < curves_.points.size(); ++i) {
      if (curves_.points[i].w > 0) continue;
      curves_.points[i].w = smallest;
      raised_thickness.add();
    }
    curves_.offsets.push_back(static_cast<uint32_t>(curves_.points.size()));
    return true;
  }

  vec3 mean_color(uint64_t first, uint64_t points) const {
    dvec3 sum(0);
    for (uint64_t i = first; i < first + points; ++i) {
      const uint64_t byte = colors_at_ + i * 12;
      const vec3 color = vector(byte);
      if (!is_finite(color)) {
        fail(byte, fmt::format("the colour of point {} is not finite", i), "mend the colour");
      }
      sum += dvec3(color);
    }
    const vec3 mean(sum / static_cast<double>(points));
    const vec3 clamped = glm::clamp(mean, vec3(0), vec3(1));
    if (clamped != mean) clamped_colors.add();
    return clamped;
  }

  std::span<const std::byte> bytes_;
  std::string file_;
  const HairOptions& options_;
  Header header_{};
  uint64_t end_ = header_bytes;  ///< of the arrays laid out so far
  uint64_t segments_at_ = 0;
  uint64_t points_at_ = 0;
  uint64_t thickness_at_ = 0;
  uint64_t colors_at_ = 0;
  Curves curves_;
};

}  // namespace

Curves load_hair(const std::filesystem::path& path, const HairOptions& options) {
  const MappedFile file(path);
  return HairReader(file.bytes(), path.string(), options).read();
}

}  // namespace relume
