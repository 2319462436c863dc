#include "core/relight/receivers.h"

namespace relume {
namespace {

/// Where a type keeps its normal: float index within the sample vector, or -1.
int normal_offset(const SampleType& type) {
  for (size_t i = 0; i < type.field_count(); ++i) {
    if (type.field(i).source == FieldSource::normal) return type.offsets[i];
  }
  return -1;
}

Receivers make_receivers(const SampleType& type, int normal, const float* slot) {
  const auto field = [slot](int i) { return slot + (1 + i) * block_lanes; };
  Receivers receivers;
  receivers.count = block_lanes;
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

}  // namespace

void query_block(const CacheInfo& info, const PackedBlock& block, const float* records,
                 const VisibilitySource& source, std::vector<float>& visibility) {
  size_t slots = 0;
  for (size_t t = 0; t < info.types.size(); ++t) slots += block.slots[t];
  visibility.resize(slots * block_lanes);
  float* out = visibility.data();
  for (size_t t = 0; t < info.types.size(); ++t) {
    const SampleType& type = info.types[t];
    const int normal = normal_offset(type);
    for (int slot = 0; slot < block.slots[t]; ++slot) {
      source.visibility(make_receivers(type, normal, records), out);
      records += (1 + type.width) * block_lanes;
      out += block_lanes;
    }
  }
}

}  // namespace relume
