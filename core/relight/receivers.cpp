#include "core/relight/receivers.h"

namespace relume {
namespace {

Receivers make_receivers(const SampleType& type, int normal, const float* slot, size_t first) {
  const auto field = [slot](int i) { return slot + (1 + i) * block_lanes; };
  Receivers receivers;
  receivers.count = block_lanes;
  receivers.first = first;
  receivers.weight = slot;
  const int position = type.offsets[position_field];
  for (int axis = 0; axis < 3; ++axis) {
    receivers.position[axis] = field(position + axis);
    if (normal >= 0) receivers.normal[axis] = field(normal + axis);
  }
  receivers.bias = field(type.offsets[bias_field]);
  receivers.lit_from_behind = type.shader->two_sided_transmission;
  return receivers;
}

/// Calls visit(receivers, slot) for each slot of a block; slots of a type count from 0.
template <class Visit>
void for_each_slot(const CacheInfo& info, const PackedBlock& block, const float* records,
                   size_t first, const Visit& visit) {
  for (size_t t = 0; t < info.types.size(); ++t) {
    const SampleType& type = info.types[t];
    const int normal = field_offset(type, FieldSource::normal);
    for (int slot = 0; slot < block.slots[t]; ++slot) {
      visit(make_receivers(type, normal, records, first), slot);
      records += (1 + type.width) * block_lanes;
      first += block_lanes;
    }
  }
}

/// The parts of a tile that lie behind its records, slot after slot.
struct FootprintReader {
  const uint32_t* footprints;
  const uint8_t* counts;
  const PackedMember* members;

  void read(bool on_surface, ReceiverGroup& group) {
    group.members.clear();
    if (footprints == nullptr) {
      group.footprints.fill(Footprint());
      return;
    }
    for (size_t lane = 0; lane < block_lanes; ++lane) {
      FootprintWords words;
      for (size_t i = 0; i < words.size(); ++i) words[i] = footprints[i * block_lanes + lane];
      Footprint& footprint = group.footprints[lane];
      footprint = decode_footprint(words);
      footprint.stored_members = counts != nullptr ? counts[lane] : 0;
      if (footprint.stored_members == 0) continue;
      const float scale = member_scale(footprint);
      for (int i = 0; i < footprint.stored_members; ++i) {
        group.members.push_back(decode_member(*members++, scale, on_surface));
      }
    }
    footprints += footprint_words * block_lanes;
    if (counts != nullptr) counts += block_lanes;
  }
};

}  // namespace

void query_block(const CacheInfo& info, const PackedBlock& block, const float* records,
                 size_t first, const VisibilitySource& source, std::vector<float>& visibility) {
  size_t slots = 0;
  for (size_t t = 0; t < info.types.size(); ++t) slots += block.slots[t];
  visibility.resize(slots * block_lanes);
  for_each_slot(info, block, records, first, [&](const Receivers& receivers, int /*slot*/) {
    source.visibility(receivers, visibility.data() + (receivers.first - first));
  });
}

ViewReceivers::ViewReceivers(const RelightCache& cache)
    : cache_(cache), decoder_(cache, InstructionSet::automatic) {}

size_t ViewReceivers::tile_first(size_t tile) const {
  return tile < tile_count() ? cache_.tiles()[tile].first_slot * block_lanes : count();
}

void ViewReceivers::visit_tile(size_t tile, const std::function<void(const ReceiverGroup&)>& visit,
                               PixelShare share) const {
  const PackedTile& packed = cache_.tiles()[tile];
  FootprintReader reader{packed.footprints, packed.member_counts, packed.members};
  size_t first = tile_first(tile);
  std::vector<float> scratch;
  ReceiverGroup group;
  const int block_count = cache_.block_count(packed, share);
  const int quarter_count = cache_.block_count(packed, PixelShare::quarter);
  for (int b = 0; b < block_count; ++b) {
    const PackedBlock block = cache_.block(packed, b);
    const float* records = decoder_.floats(block, scratch);
    group.share = b < quarter_count ? PixelShare::quarter : PixelShare::all;
    for_each_slot(cache_.info(), block, records, first, [&](const Receivers& receivers, int slot) {
      group.receivers = receivers;
      group.slot = slot;
      reader.read(receivers.normal[0] != nullptr, group);
      visit(group);
      first += block_lanes;
    });
  }
}

}  // namespace relume
