#include "core/samples/pack.h"

#include <algorithm>
#include <cstring>

#include "core/base/check.h"
#include "core/samples/cache_format.h"
#include "core/samples/pixel_share.h"
#include "core/samples/record_encode.h"

namespace relume {
namespace {

uint32_t rows_of(const TypedRows& rows, int pixel) {
  return rows.first[pixel + 1] - rows.first[pixel];
}

PixelShare share_of(const SampleTile& tile, int pixel) {
  return first_share_of(tile.x0 + pixel % tile.width, tile.y0 + pixel / tile.width);
}

/// The tile's pixels that have records, sorted by share, by record counts type by type, then by
/// position.
std::vector<int> sorted_pixels(const SampleTile& tile) {
  std::vector<int> pixels;
  for (int pixel = 0; pixel < tile.pixel_count(); ++pixel) {
    const bool any = std::any_of(tile.types.begin(), tile.types.end(),
                                 [&](const TypedRows& rows) { return rows_of(rows, pixel) > 0; });
    if (any) pixels.push_back(pixel);
  }
  std::stable_sort(pixels.begin(), pixels.end(), [&](int a, int b) {
    if (share_of(tile, a) != share_of(tile, b)) return share_of(tile, a) < share_of(tile, b);
    for (const TypedRows& rows : tile.types) {
      const uint32_t count_a = rows_of(rows, a);
      const uint32_t count_b = rows_of(rows, b);
      if (count_a != count_b) return count_a > count_b;
    }
    return false;
  });
  return pixels;
}

/// Writes one slot of the exact format: record `slot` of each lane's pixel; lanes without one get
/// weight 0 and the values of the first lane that has one.
void pack_exact_slot(const TypedRows& rows, std::span<const int> lanes, uint32_t slot, int width,
                     uint32_t* out) {
  size_t filler = 0;
  while (rows_of(rows, lanes[filler]) <= slot) ++filler;
  for (size_t lane = 0; lane < block_lanes; ++lane) {
    const bool present = lane < lanes.size() && rows_of(rows, lanes[lane]) > slot;
    const size_t row = size_t{rows.first[lanes[present ? lane : filler]]} + slot;
    out[lane] = std::bit_cast<uint32_t>(present ? rows.weights[row] : 0.0f);
    const float* values = &rows.values[row * width];
    for (int i = 0; i < width; ++i) {
      out[(1 + i) * block_lanes + lane] = std::bit_cast<uint32_t>(values[i]);
    }
  }
}

/// The same in a packed format.
void pack_slot(const RecordLayout& layout, const TypedRows& rows, std::span<const int> lanes,
               uint32_t slot, const BlockFrame& frame, const ViewAxes& axes, uint32_t* out) {
  uint32_t words[max_record_words];
  for (size_t lane = 0; lane < lanes.size(); ++lane) {
    if (rows_of(rows, lanes[lane]) <= slot) continue;
    const size_t row = size_t{rows.first[lanes[lane]]} + slot;
    encode_record(layout, &rows.values[row * layout.width], rows.weights[row], frame, axes, words);
    for (int i = 0; i < layout.words; ++i) out[i * block_lanes + lane] = words[i];
  }
}

/// Writes the footprints and members of one slot; lanes without a record get zeros.
void pack_footprints(const SampleTile& tile, const TypedRows& rows, std::span<const int> lanes,
                     uint32_t slot, std::span<const uint32_t> first_member,
                     PackedTileData& packed) {
  const size_t start = packed.footprints.size();
  packed.footprints.resize(start + footprint_words * block_lanes);
  for (size_t lane = 0; lane < block_lanes; ++lane) {
    uint8_t count = 0;
    if (lane < lanes.size() && rows_of(rows, lanes[lane]) > slot) {
      const size_t row = size_t{rows.first[lanes[lane]]} + slot;
      const FootprintWords words = encode_footprint(rows.footprints[row]);
      for (size_t i = 0; i < words.size(); ++i) {
        packed.footprints[start + i * block_lanes + lane] = words[i];
      }
      const float scale = member_scale(decode_footprint(words));
      count = static_cast<uint8_t>(rows.footprints[row].stored_members);
      for (size_t i = 0; i < count; ++i) {
        packed.members.push_back(encode_member(rows.members[first_member[row] + i], scale));
      }
    }
    if (tile.has_members) packed.member_counts.push_back(count);
  }
}

/// Per row and one more: where its members start.
std::vector<uint32_t> first_members(const TypedRows& rows) {
  std::vector<uint32_t> first{0};
  for (const Footprint& footprint : rows.footprints) {
    first.push_back(first.back() + static_cast<uint32_t>(footprint.stored_members));
  }
  CHECK_MSG(first.back() == rows.members.size(), "{} {}", first.back(), rows.members.size());
  return first;
}

/// Calls visit(type, sample vector) for each record of a block's pixels.
template <class Visit>
void for_each_vector(const SampleTile& tile, std::span<const SampleType> types,
                     std::span<const int> lanes, const Visit& visit) {
  for (size_t t = 0; t < types.size(); ++t) {
    const TypedRows& rows = tile.types[t];
    for (const int pixel : lanes) {
      for (uint32_t row = rows.first[pixel]; row < rows.first[pixel + 1]; ++row) {
        visit(t, &rows.values[size_t{row} * types[t].width]);
      }
    }
  }
}

/// Writes a packed block's frame and the bias of each type.
BlockFrame pack_frame(const SampleTile& tile, std::span<const SampleType> types,
                      std::span<const int> lanes, std::span<const RecordLayout> layouts,
                      const ViewAxes& axes, std::byte* out) {
  std::vector<vec3> positions;
  for_each_vector(tile, types, lanes, [&](size_t, const float* v) {
    positions.push_back({v[0], v[1], v[2]});
  });
  const BlockFrame frame = make_block_frame(axes, positions);
  std::vector<float> biases(types.size());
  for_each_vector(tile, types, lanes, [&](size_t t, const float* v) {
    const float bias =
        packed_bias(layouts[t], frame, axes, {v[0], v[1], v[2]}, v[types[t].offsets[bias_field]]);
    biases[t] = std::max(biases[t], bias);
  });
  std::memcpy(out, frame.data(), sizeof(frame));
  std::memcpy(out + sizeof(frame), biases.data(), biases.size() * sizeof(float));
  return frame;
}

float pixel_coverage(const SampleTile& tile, int pixel) {
  if (!tile.coverage.empty()) return tile.coverage[pixel];
  float coverage = 0;
  for (const TypedRows& rows : tile.types) {
    for (uint32_t row = rows.first[pixel]; row < rows.first[pixel + 1]; ++row) {
      coverage += rows.weights[row];
    }
  }
  return coverage;
}

RareEvent replaced_errors("predicted errors that were not finite");

/// What the cache stores for a pixel's predicted error.
float stored_error(float error, bool covered) {
  CHECK_MSG(!(error < 0), "predicted error {}", error);
  if (!covered) return 0;
  if (is_finite(error)) return error;
  replaced_errors.add();
  return std::numeric_limits<float>::max();
}

void pack_block(const SampleTile& tile, std::span<const SampleType> types,
                std::span<const int> lanes, const ViewAxes& axes,
                std::span<const std::vector<uint32_t>> members, PackedTileData& packed) {
  std::vector<std::byte> header(block_stride(types.size(), packed.format));
  const auto first_word = static_cast<uint32_t>(packed.words.size());
  CHECK(packed.words.size() < uint64_t{1} << 32);
  std::memcpy(header.data(), &first_word, sizeof(first_word));
  header[block_lanes_offset] = static_cast<std::byte>(lanes.size());
  for (size_t lane = 0; lane < block_lanes; ++lane) {
    const int pixel = lanes[lane < lanes.size() ? lane : 0];
    header[block_pixels_offset + lane] =
        static_cast<std::byte>(pixel / tile.width * tile_size + pixel % tile.width);
  }
  std::vector<RecordLayout> layouts;
  for (const SampleType& type : types) {
    layouts.push_back(make_record_layout(type.shader->fields, packed.format));
  }
  const bool is_exact = packed.format == CacheFormat::exact;
  BlockFrame frame{};
  if (!is_exact) {
    frame =
        pack_frame(tile, types, lanes, layouts, axes, &header[block_frame_offset(types.size())]);
  }
  for (size_t t = 0; t < types.size(); ++t) {
    const TypedRows& rows = tile.types[t];
    const RecordLayout& layout = layouts[t];
    uint32_t slots = 0;
    for (const int pixel : lanes) {
      slots = std::max(slots, rows_of(rows, pixel));
      packed.record_count += rows_of(rows, pixel);
    }
    const auto stored = static_cast<uint16_t>(slots);
    std::memcpy(&header[block_slots_offset + 2 * t], &stored, sizeof(stored));
    const size_t slot_words = static_cast<size_t>(layout.words) * block_lanes;
    const size_t start = packed.words.size();
    packed.words.resize(start + slots * slot_words);
    for (uint32_t slot = 0; slot < slots; ++slot) {
      uint32_t* out = &packed.words[start + slot * slot_words];
      if (is_exact) {
        pack_exact_slot(rows, lanes, slot, types[t].width, out);
      } else {
        pack_slot(layout, rows, lanes, slot, frame, axes, out);
      }
      if (tile.has_footprints) pack_footprints(tile, rows, lanes, slot, members[t], packed);
    }
  }
  packed.blocks.insert(packed.blocks.end(), header.begin(), header.end());
  ++packed.block_count;
}

}  // namespace

PackedTileData pack_tile(const SampleTile& records, std::span<const SampleType> types,
                         const PackParams& params) {
  CHECK_MSG(records.types.size() == types.size(), "{} {}", records.types.size(), types.size());
  PackedTileData packed;
  packed.format = params.format;
  const ViewAxes axes = make_view_axes(params.camera);
  packed.x0 = records.x0;
  packed.y0 = records.y0;
  packed.width = records.width;
  packed.height = records.height;
  packed.has_footprints = records.has_footprints;
  packed.has_members = records.has_members;
  CHECK(!records.has_members || records.has_footprints);
  std::vector<std::vector<uint32_t>> members;
  for (const TypedRows& rows : records.types) {
    if (!records.has_footprints) continue;
    CHECK_MSG(rows.footprints.size() == rows.rows(), "{} {}", rows.footprints.size(), rows.rows());
    members.push_back(first_members(rows));
  }
  const std::vector<int> pixels = sorted_pixels(records);
  for (size_t i = 0; i < pixels.size();) {
    size_t lanes = 1;
    while (lanes < block_lanes && i + lanes < pixels.size() &&
           share_of(records, pixels[i + lanes]) == share_of(records, pixels[i])) {
      ++lanes;
    }
    pack_block(records, types, std::span(pixels).subspan(i, lanes), axes, members, packed);
    i += lanes;
  }
  for (int pixel = 0; pixel < records.pixel_count(); ++pixel) {
    const float coverage = pixel_coverage(records, pixel);
    // A pixel that geometry touches counts as covered, however little.
    const float code = std::min(255.0f, std::ceil(coverage * 255.0f - 0.5f));
    packed.coverage.push_back(static_cast<uint8_t>(coverage > 0 ? std::max(1.0f, code) : 0.0f));
    if (!records.predicted_error.empty()) {
      packed.predicted_error.push_back(stored_error(records.predicted_error[pixel], coverage > 0));
    }
  }
  for (const vec3 emission : records.emission) {
    for (int c = 0; c < 3; ++c) packed.emission.push_back(emission[c]);
  }
  return packed;
}

}  // namespace relume
