#include "tests/support/merged_cache.h"

#include "core/samples/cache_writer.h"
#include "core/samples/pack.h"
#include "core/samples/sample_scene.h"
#include "core/shade/shaders.h"
#include "tests/support/scenes.h"

namespace relume::test {

RelightCache make_merged_cache(const Scene& scene, const Tracer& tracer, int spp, int stored,
                               uint64_t seed) {
  const ViewSampler view = make_view_sampler(scene, tracer, scene.width, scene.height, spp, seed);
  CacheWriter writer;
  for (int i = 0; i < tile_count(view); ++i) {
    const SampleTile samples = sample_tile(view, i);
    SampleTile records = samples;
    records.has_footprints = true;
    records.has_members = stored > 0;
    for (size_t t = 0; t < samples.types.size(); ++t) {
      const TypedRows& rows = samples.types[t];
      const SampleType& type = view.types.types[t];
      const int normal = field_offset(type, FieldSource::normal);
      TypedRows& out = records.types[t];
      out = TypedRows();
      out.first.push_back(0);
      for (int pixel = 0; pixel < samples.pixel_count(); ++pixel) {
        const uint32_t begin = rows.first[pixel];
        const uint32_t end = rows.first[pixel + 1];
        if (end > begin) {
          const float* anchor = &rows.values[size_t{begin} * type.width];
          out.values.insert(out.values.end(), anchor, anchor + type.width);
          out.weights.push_back(static_cast<float>(end - begin) / static_cast<float>(spp));
          Footprint& footprint = out.footprints.emplace_back();
          footprint.samples = static_cast<int>(end - begin);
          footprint.stored_members = end - begin < 2 ? 0 : std::min<int>(stored, end - begin);
          // All of the spread along one axis bounds the offsets whatever they are.
          float largest = 0;
          for (int m = 0; m < footprint.samples; ++m) {
            const float* v = anchor + static_cast<size_t>(m) * type.width;
            Member member;
            member.offset = vec3(v[0], v[1], v[2]) - vec3(anchor[0], anchor[1], anchor[2]);
            if (normal >= 0) member.normal = vec3(v[normal], v[normal + 1], v[normal + 2]);
            largest = std::max(largest, max_abs_component(member.offset));
            if (m < footprint.stored_members) out.members.push_back(member);
          }
          footprint.covariance[0] = largest * largest;
        }
        out.first.push_back(static_cast<uint32_t>(out.rows()));
      }
    }
    writer.add(pack_tile(records, view.types.types));
  }
  writer.finish(make_cache_info(scene, view.types, spp, seed));
  return RelightCache::from_bytes(writer.take_bytes(), shader_table(), "merged");
}

std::vector<double> pixel_visibility(const RelightCache& cache, VisibilitySource& source,
                                     const Light& light) {
  const CacheInfo& info = cache.info();
  source.prepare(light);
  std::vector<double> sums(static_cast<size_t>(info.width) * info.height);
  for (const PackedTile& tile : cache.tiles()) {
    size_t receiver = tile.first_slot * block_lanes;
    for (int b = 0; b < tile.block_count; ++b) {
      const PackedBlock block = cache.block(tile, b);
      const float* slot = block.floats();
      for (size_t t = 0; t < info.types.size(); ++t) {
        for (int s = 0; s < block.slots[t]; ++s) {
          Receivers receivers;
          receivers.count = block_lanes;
          receivers.first = receiver;
          float visibility[block_lanes];
          source.visibility(receivers, visibility);
          for (int lane = 0; lane < block.lanes; ++lane) {
            const int x = tile.x0 + block.pixels[lane] % tile_size;
            const int y = tile.y0 + block.pixels[lane] / tile_size;
            sums[static_cast<size_t>(y) * info.width + x] += slot[lane] * visibility[lane];
          }
          slot += (1 + info.types[t].width) * block_lanes;
          receiver += block_lanes;
        }
      }
    }
  }
  return sums;
}

}  // namespace relume::test
