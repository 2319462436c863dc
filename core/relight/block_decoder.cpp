#include "core/relight/block_decoder.h"

#include "core/base/check.h"
#include "core/shade/shaders.h"

namespace relume {

BlockDecoder::BlockDecoder(const RelightCache& cache, InstructionSet set)
    : cache_(cache), kernels_(block_kernels(choose_instruction_set(set))) {
  const auto table = shader_table();
  for (const SampleType& type : cache.info().types) {
    const auto found = std::find(table.begin(), table.end(), type.shader);
    CHECK(found != table.end());
    shaders_.push_back(static_cast<int>(found - table.begin()));
  }
}

const float* BlockDecoder::floats(const PackedBlock& block, std::vector<float>& scratch) const {
  const CacheInfo& info = cache_.info();
  if (info.format == CacheFormat::exact) return block.floats();
  size_t size = 0;
  for (size_t t = 0; t < info.types.size(); ++t) {
    size += static_cast<size_t>(block.slots[t]) * (1 + info.types[t].width) * block_lanes;
  }
  scratch.resize(size);
  const uint32_t* words = block.words;
  float* out = scratch.data();
  for (size_t t = 0; t < info.types.size(); ++t) {
    const size_t slots = block.slots[t];
    const float bias = block.frame[block_frame_floats + t];
    kernels_.decode_slots(
        {info.format, shaders_[t], words, block.frame, bias, &cache_.view_axes(), block.slots[t]},
        out);
    words += slots * cache_.layouts()[t].words * block_lanes;
    out += slots * (1 + info.types[t].width) * block_lanes;
  }
  return scratch.data();
}

}  // namespace relume
