#include "viewer/aovs/deep_records.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/math/half.h"
#include "core/relight/block_decoder.h"
#include "core/relight/receivers.h"
#include "core/samples/sample_tile.h"
#include "core/shade/reference.h"
#include "viewer/aovs/channel_names.h"

namespace relume {
namespace {

/// A record of a pixel.
struct DeepRecord {
  float depth = 0;  ///< along the view axis, world units
  float weight = 0;
  int type = 0;
  size_t receiver = 0;
  const float* values = nullptr;  ///< component i is values[i * block_lanes]
};

// Channels that every deep image has, in this order; the fields' come behind.
enum FixedChannel { red, green, blue, alpha, depth, weight, id, fixed_channels };

class DeepRecordMaker {
 public:
  explicit DeepRecordMaker(const RelightCache& cache)
      : cache_(cache),
        decoder_(cache, InstructionSet::automatic),
        rays_(cache.info().camera, cache.info().width, cache.info().height),
        radiance_(cache.slot_count() * block_lanes, vec3(0)),
        emission_(cache.emission()) {
    image_.width = cache.info().width;
    image_.height = cache.info().height;
    for (const char* name : {"R", "G", "B", "A", "Z", "weight.V", "id.V"}) {
      image_.channels.push_back({name, true});
    }
    image_.channels[depth].is_half = image_.channels[weight].is_half = false;
    for (const SampleType& type : cache.info().types) add_channels(type);
  }

  /// Adds what a light sends to the eye from each record.
  void add_light(const Light& light, const VisibilitySource* shadows) {
    const CacheInfo& info = cache_.info();
    for_each_block([&](const PackedTile&, const PackedBlock& block, const float* records,
                       size_t first, std::vector<float>& visibility) {
      if (shadows != nullptr) query_block(info, block, records, first, *shadows, visibility);
      for (int lane = 0; lane < block.lanes; ++lane) {
        for_each_record(block, records, first, lane, [&](const DeepRecord& record) {
          const size_t at = record.receiver - first;
          const float seen = shadows != nullptr ? visibility[at] : 1.0f;
          radiance_[record.receiver] += seen * shade(record, light);
        });
      }
    });
  }

  DeepImage make() {
    count_samples();
    for_each_block([&](const PackedTile& tile, const PackedBlock& block, const float* records,
                       size_t first, std::vector<float>&) {
      std::vector<DeepRecord> pixel;
      for (int lane = 0; lane < block.lanes; ++lane) {
        pixel.clear();
        for_each_record(block, records, first, lane,
                        [&](const DeepRecord& record) { pixel.push_back(record); });
        const size_t x = tile.x0 + block.pixels[lane] % tile_size;
        const size_t y = tile.y0 + block.pixels[lane] / tile_size;
        write_pixel(pixel, y * image_.width + x);
      }
    });
    return std::move(image_);
  }

 private:
  /// Calls visit(tile, block, records, first receiver, scratch), tiles in parallel.
  template <class Visit>
  void for_each_block(const Visit& visit) const {
    const auto tiles = cache_.tiles();
    parallel_for(tiles.size(), 1, [&](size_t begin, size_t end) {
      std::vector<float> decoded;
      std::vector<float> scratch;
      for (size_t t = begin; t < end; ++t) {
        size_t receiver = tiles[t].first_slot * block_lanes;
        for (int b = 0; b < tiles[t].block_count; ++b) {
          const PackedBlock block = cache_.block(tiles[t], b);
          visit(tiles[t], block, decoder_.floats(block, decoded), receiver, scratch);
          for (size_t i = 0; i < cache_.info().types.size(); ++i) {
            receiver += size_t{block.slots[i]} * block_lanes;
          }
        }
      }
    });
  }

  template <class Visit>
  void for_each_record(const PackedBlock& block, const float* records, size_t receiver, int lane,
                       const Visit& visit) const {
    const auto& types = cache_.info().types;
    for (size_t t = 0; t < types.size(); ++t) {
      for (int slot = 0; slot < block.slots[t]; ++slot, receiver += block_lanes) {
        if (records[lane] > 0) {
          DeepRecord record{0, records[lane], static_cast<int>(t), receiver + lane,
                            records + block_lanes + lane};
          const vec3 position(record.values[0], record.values[block_lanes],
                              record.values[2 * block_lanes]);
          record.depth = glm::dot(position - rays_.eye(), rays_.forward());
          visit(record);
        }
        records += (1 + types[t].width) * block_lanes;
      }
    }
  }

  vec3 shade(const DeepRecord& record, const Light& light) const {
    const CacheInfo& info = cache_.info();
    const SampleType& type = info.types[record.type];
    float vector[64];
    for (int i = 0; i < type.width; ++i) vector[i] = record.values[i * block_lanes];
    return vec3(reference_response(type, vector, light, dvec3(info.camera.eye),
                                   info.bounds.radius())) *
           light.weight();
  }

  void add_channels(const SampleType& type) {
    std::vector<size_t>& first_of_field = channel_of_field_.emplace_back();
    for (size_t i = 0; i < type.field_count(); ++i) {
      const SampleField& field = type.field(i);
      const std::vector<std::string> components = components_of(field);
      const auto found = std::find_if(image_.channels.begin(), image_.channels.end(),
                                      [&](const DeepChannel& channel) {
                                        return channel.name == layer_of(field) + components.front();
                                      });
      first_of_field.push_back(static_cast<size_t>(found - image_.channels.begin()));
      if (found != image_.channels.end()) continue;
      const bool is_length =
          field.source == FieldSource::position || field.source == FieldSource::bias;
      for (const std::string& component : components) {
        image_.channels.push_back({layer_of(field) + component, !is_length});
      }
    }
  }

  /// Fills counts and makes room for the values.
  void count_samples() {
    const std::vector<float> counts = cache_.record_counts();
    image_.counts.assign(counts.begin(), counts.end());
    first_sample_.assign(1, 0);
    for (const uint32_t count : image_.counts) {
      first_sample_.push_back(first_sample_.back() + count);
    }
    image_.values.assign(first_sample_.back() * image_.channels.size(), 0.0f);
  }

  /// Sorts the pixel's records and writes them so that "over" gives their weighted sum: with T the
  /// transmittance in front of a record, its colour is weight * radiance / T and its alpha takes T
  /// to 1 - the weights so far. T follows the alphas as they are stored, so that nothing adds up.
  void write_pixel(std::vector<DeepRecord>& pixel, size_t index) {
    std::stable_sort(pixel.begin(), pixel.end(),
                     [](const DeepRecord& a, const DeepRecord& b) { return a.depth < b.depth; });
    constexpr float most_alpha = 1 - 0x1p-11f;  // of half floats below 1
    double transmittance = 1;
    double weights = 0;
    const vec3 emission = emitted_radiance(pixel, index);
    float* out = &image_.values[first_sample_[index] * image_.channels.size()];
    for (size_t i = 0; i < pixel.size(); ++i, out += image_.channels.size()) {
      const DeepRecord& record = pixel[i];
      weights += record.weight;
      const double wanted = 1 - std::max(0.0, 1 - weights) / transmittance;
      const bool is_last = i + 1 == pixel.size();
      out[alpha] =
          std::clamp(nearest_half(static_cast<float>(wanted)), 0.0f, is_last ? 1.0f : most_alpha);
      const vec3 color = (radiance_[record.receiver] + emission) *
                         static_cast<float>(record.weight / transmittance);
      for (int c = 0; c < 3; ++c) out[red + c] = nearest_half(color[c]);
      out[depth] = record.depth;
      out[weight] = record.weight;
      out[id] = id_of_shader(cache_.info().types[record.type].shader);
      write_fields(record, out);
      transmittance *= 1 - double{out[alpha]};
    }
  }

  /// What a pixel emits, shared among its records by their weights: where in depth it comes from
  /// is not stored.
  vec3 emitted_radiance(const std::vector<DeepRecord>& pixel, size_t index) const {
    if (emission_.empty()) return vec3(0);
    float weights = 0;
    for (const DeepRecord& record : pixel) weights += record.weight;
    return vec3(emission_[3 * index], emission_[3 * index + 1], emission_[3 * index + 2]) / weights;
  }

  void write_fields(const DeepRecord& record, float* out) const {
    const SampleType& type = cache_.info().types[record.type];
    for (size_t i = 0; i < type.field_count(); ++i) {
      const size_t first = channel_of_field_[record.type][i];
      for (int c = 0; c < type.field(i).width; ++c) {
        const float value = record.values[(type.offsets[i] + c) * block_lanes];
        out[first + c] = image_.channels[first].is_half ? nearest_half(value) : value;
      }
    }
  }

  const RelightCache& cache_;
  BlockDecoder decoder_;
  CameraRays rays_;
  std::vector<vec3> radiance_;   ///< of each receiver, without its weight
  std::vector<float> emission_;  ///< of each pixel, RGB; empty: none
  DeepImage image_;
  std::vector<std::vector<size_t>> channel_of_field_;  ///< per type, per field
  std::vector<size_t> first_sample_;                   ///< per pixel
};

}  // namespace

DeepImage make_deep_records(const RelightCache& cache, std::span<const Light> lights,
                            VisibilitySource* shadows) {
  if (cache.info().format != CacheFormat::exact) {
    throw input_error(cache.info().scene_name, "packed caches keep no weights",
                      "prepare with --format exact");
  }
  DeepRecordMaker maker(cache);
  for (const Light& light : lights) {
    if (light.mute) continue;
    const bool is_shadowed = shadows != nullptr && light.casts_shadow;
    if (is_shadowed) shadows->prepare(light);
    maker.add_light(light, is_shadowed ? shadows : nullptr);
  }
  return maker.make();
}

}  // namespace relume
