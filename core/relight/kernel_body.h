#pragma once

// The one kernel source: included by one tiny source file per instruction set, which defines
// RELUME_ISA. Pure functions on flat arrays; no std:: or glm:: calls (see core/simd/pack.h).

#include "core/relight/kernel.h"
#include "core/relight/layer_kernel_body.h"
#include "core/samples/record_decode.h"
#include "core/shade/incident.h"
#include "core/shade/shader_list.h"
#include "core/simd/pack.h"

namespace relume::RELUME_ISA {

inline constexpr int lanes = block_lanes;

/// Radiance towards wo: the lobes times their colours and `scale`.
template <class Shader, class Load>
V respond(const Load& field, V wi, V wo, F scale) {
  const auto lobes = Shader::template lobes<F>(field, wi, wo);
  V sum{};
  int k = 0;
  for (const int color : Shader::colors) {
    const F lobe = lobes.value[k] * scale;
    const V rgb{field(color), field(color + 1), field(color + 2)};
    sum = k++ == 0 ? rgb * lobe
                   : V{fma(rgb.x, lobe, sum.x), fma(rgb.y, lobe, sum.y), fma(rgb.z, lobe, sum.z)};
  }
  return sum;
}

template <class Shader, CacheFormat format>
inline constexpr RecordLayout layout_of = make_record_layout(Shader::fields, format);

/// A pack of records, decoded.
template <class Shader, CacheFormat format>
struct Record {
  static constexpr const RecordLayout& layout = layout_of<Shader, format>;
  F weight;  ///< 1 in packed formats, whose colours hold it
  F values[layout.width];

  [[gnu::always_inline]] Record(const uint32_t* words, const DecodeFrame& frame) : weight(1) {
    if constexpr (format == CacheFormat::exact) weight = from_bits<native_width>(load_word(words));
    decode_fields<0>(words, frame);
  }

 private:
  template <int i>
  [[gnu::always_inline]] void decode_fields(const uint32_t* words, const DecodeFrame& frame) {
    if constexpr (i < layout.field_count) {
      constexpr PackedField field = layout.fields[i];
      decode_field(field, words, frame, values + field.first);
      decode_fields<i + 1>(words, frame);
    }
  }
};

/// One slot of some block.
struct Slot {
  const uint32_t* words;
  const float* frame;       ///< of packed formats
  const float* visibility;  ///< 16 values
  float* sums;              ///< its block's under the first light
};

/// Slots of one type. Kernels take them in groups and may shade more than `count`, up to a full
/// group: the list is padded with slots whose sums nobody reads.
struct SlotList {
  static constexpr int capacity = 64;
  static constexpr int group = 8;  ///< at most, and divides the capacity
  Slot slots[capacity];
  int count = 0;
  uintptr_t ahead = 0;  ///< what to prefetch next
};

/// What slots are shaded with.
template <int count>
struct Illumination {
  ViewPack view;
  LightPack lights[count];
};

/// What one pack of records sends to the eye under each light. A record is decoded once for all.
template <class Shader, CacheFormat format, LightKernel kind, int count>
void shade_pack(const Slot& slot, int lane, const Illumination<count>& by, V* radiance) {
  const Record<Shader, format> record(slot.words + lane, {slot.frame, 0, by.view});
  const auto field = [&record](int i) { return record.values[i]; };
  const V p{field(0), field(1), field(2)};
  const V wo = direction_to(by.view.eye, p);
  const F weight = record.weight * F::load(slot.visibility + lane);
#pragma GCC unroll 4
  for (int i = 0; i < count; ++i) {
    const Incident in = incident<kind>(by.lights[i], p);
    radiance[i] = respond<Shader>(field, in.wi, wo, weight * in.irradiance);
  }
}

template <int count>
void add_radiance(const V* radiance, float* sums) {
#pragma GCC unroll 4
  for (int i = 0; i < count; ++i) {
    float* const rgb = sums + tile_floats * i;
    const V sum = load_vec3<native_width>(rgb, lanes);
    store_vec3(V{sum.x + radiance[i].x, sum.y + radiance[i].y, sum.z + radiance[i].z}, rgb, lanes);
  }
}

/// Loop bodies are one straight piece of code, for one, two or four lights and several packs. Not
/// under a sanitizer, with whose checks that takes minutes and gigabytes to compile: then one light
/// and one pack at a time, to the same bits.
#if defined(RELUME_SANITIZED)
#define RELUME_FLATTEN
inline constexpr bool is_unrolled = false;
#else
#define RELUME_FLATTEN [[gnu::flatten]]
inline constexpr bool is_unrolled = true;
#endif

/// Packs that are shaded side by side: the chain of dependent operations of one record under one
/// light is longer than what a core looks ahead. With more packs than this, records would come from
/// memory in an order that its prefetchers do not foresee, and registers would not suffice.
constexpr int packs_together(int lights) {
  const int chains = native_width == lanes ? 2 : 4;
  return is_unrolled && chains > lights ? chains / lights : 1;
}

/// How far ahead of a tile's data its successors' are asked for: beyond the tile itself, since its
/// records are taken type by type, and within the second-level cache.
inline constexpr int prefetch_bytes = 128 << 10;

/// Asks for the next `bytes` of the cache, in the order in which they lie there. What lies beyond
/// its end is not there to be had, which does no harm.
template <int bytes>
void prefetch_next(uintptr_t& ahead) {
#pragma GCC unroll 64
  for (int line = 0; line < bytes; line += 64) {
    __builtin_prefetch(reinterpret_cast<const void*>(ahead + line));
  }
  ahead += bytes;
}

/// Shades slots of one shader under `count` lights. A lane's sum goes in the list's order.
/// Flattened, so that the chains of a loop body overlap.
template <class Shader, CacheFormat format, LightKernel kind, int count>
RELUME_FLATTEN void shade_slots(const SlotList& list, const ViewAxes& axes,
                                const KernelLight* lights) {
  constexpr int packs = packs_together(count);
  constexpr int parts = lanes / native_width < packs ? lanes / native_width : packs;
  constexpr int slots = packs / parts;
  Illumination<count> by{broadcast(axes), {}};
#pragma GCC unroll 4
  for (int i = 0; i < count; ++i) by.lights[i] = broadcast(lights[i]);
  uintptr_t ahead = list.ahead;
  for (int first = 0; first < list.count; first += slots) {
    constexpr int slot_bytes = layout_of<Shader, format>.words * lanes * int{sizeof(uint32_t)};
    prefetch_next<slots * slot_bytes>(ahead);
    for (int lane = 0; lane < lanes; lane += parts * native_width) {
      V radiance[packs][count];
#pragma GCC unroll 8
      for (int pack = 0; pack < packs; ++pack) {
        shade_pack<Shader, format, kind>(list.slots[first + pack / parts],
                                         lane + pack % parts * native_width, by, radiance[pack]);
      }
#pragma GCC unroll 8
      for (int pack = 0; pack < packs; ++pack) {
        const int offset = lane + pack % parts * native_width;
        add_radiance<count>(radiance[pack], list.slots[first + pack / parts].sums + offset);
      }
    }
  }
}

using ShadeSlots = void (*)(const SlotList&, const ViewAxes&, const KernelLight*);

/// Kernels of one shader, format and light kind.
struct ShaderKernels {
  ShadeSlots one;
  ShadeSlots two;
  ShadeSlots four;
  int slot_words;
};

template <class Shader, CacheFormat format, LightKernel kind>
constexpr ShaderKernels kernels_of() {
  constexpr int words = layout_of<Shader, format>.words * lanes;
  if constexpr (is_unrolled) {
    return {shade_slots<Shader, format, kind, 1>, shade_slots<Shader, format, kind, 2>,
            shade_slots<Shader, format, kind, 4>, words};
  } else {
    return {shade_slots<Shader, format, kind, 1>, nullptr, nullptr, words};
  }
}

/// Writes one type's slots as floats, see BlockKernels::decode_slots.
template <class Shader, CacheFormat format>
void decode_slots_of(const EncodedSlots& slots, float* out) {
  constexpr const RecordLayout& layout = layout_of<Shader, format>;
  const ViewPack view = broadcast(*slots.axes);
  for (int slot = 0; slot < slots.count; ++slot) {
    const uint32_t* words = slots.words + slot * layout.words * lanes;
    for (int lane = 0; lane < lanes; lane += native_width) {
      const Record<Shader, format> record(words + lane, {slots.frame, slots.bias, view});
      F weight = record.weight;
      if constexpr (format != CacheFormat::exact) {
        F brightest(0);
        for (const int color : Shader::colors) {
          for (int i = 0; i < 3; ++i) brightest = max(record.values[color + i], brightest);
        }
        weight = select(brightest > F(0), F(1), F(0));
      }
      weight.store(out + lane);
      for (int i = 0; i < layout.width; ++i) record.values[i].store(out + (1 + i) * lanes + lane);
    }
    out += (1 + layout.width) * lanes;
  }
}

struct ShaderTable {
  ShaderKernels by_kind[static_cast<int>(LightKernel::count)];
  void (*decode)(const EncodedSlots&, float*);
};

template <class Shader, CacheFormat format, int... kinds>
constexpr ShaderTable table_of(std::integer_sequence<int, kinds...>) {
  return {{kernels_of<Shader, format, static_cast<LightKernel>(kinds)>()...},
          decode_slots_of<Shader, format>};
}

template <CacheFormat format, class... Shaders>
const ShaderTable* format_table(ShaderList<Shaders...>) {
  static constexpr ShaderTable table[] = {table_of<Shaders, format>(LightKernels{})...};
  return table;
}

inline const ShaderTable* kernel_table(CacheFormat format) {
  switch (format) {
    case CacheFormat::standard:
      return format_table<CacheFormat::standard>(AllShaders{});
    case CacheFormat::compact:
      return format_table<CacheFormat::compact>(AllShaders{});
    case CacheFormat::exact:
      break;
  }
  return format_table<CacheFormat::exact>(AllShaders{});
}

/// Shades slots of one type under all lights, in passes of four, two and one.
inline void shade_list(const ShaderKernels& kernels, SlotList& list, const KernelTile& tile,
                       float* unread) {
  if (list.count == 0) return;
  for (int i = list.count; i % SlotList::group != 0; ++i) {
    list.slots[i] = list.slots[i - 1];
    list.slots[i].sums = unread;
  }
  for (int done = 0; done < tile.light_count;) {
    const int left = tile.light_count - done;
    const int now = !is_unrolled ? 1 : left >= 4 ? 4 : left >= 2 ? 2 : 1;
    const ShadeSlots shade = now == 4 ? kernels.four : now == 2 ? kernels.two : kernels.one;
    shade(list, *tile.axes, tile.lights + done);
    done += now;
    for (int i = 0; i < list.count; ++i) list.slots[i].sums += tile_floats * now;
  }
  list.ahead += static_cast<uintptr_t>(list.count) * kernels.slot_words * sizeof(uint32_t);
  list.count = 0;
}

/// Where the next type of a block starts.
struct BlockCursor {
  const uint32_t* words;
  const float* visibility;
};

void shade_blocks(const KernelTile& tile) {
  const ShaderTable* const table = kernel_table(tile.format);
  alignas(64) float unread[(max_kernel_lights - 1) * tile_floats + block_floats] = {};
  alignas(64) static constexpr float all_visible[lanes] = {1, 1, 1, 1, 1, 1, 1, 1,
                                                           1, 1, 1, 1, 1, 1, 1, 1};
  BlockCursor cursors[max_tile_blocks];
  for (int b = 0; b < tile.block_count; ++b) {
    cursors[b] = {tile.blocks[b].words, tile.blocks[b].visibility};
  }
  for (int i = 0; i < tile.light_count; ++i) {
    __builtin_memset(tile.sums + i * tile_floats, 0,
                     sizeof(float) * block_floats * tile.block_count);
  }
  const int kind = static_cast<int>(tile.lights[0].kind);
  SlotList list;
  list.ahead = reinterpret_cast<uintptr_t>(tile.blocks[0].words) + prefetch_bytes;
  for (int type = 0; type < tile.type_count; ++type) {
    const ShaderKernels& kernels = table[tile.shaders[type]].by_kind[kind];
    for (int b = 0; b < tile.block_count; ++b) {
      BlockCursor& at = cursors[b];
      for (int slot = 0; slot < tile.blocks[b].slots[type]; ++slot) {
        list.slots[list.count++] = {at.words, tile.blocks[b].frame,
                                    at.visibility != nullptr ? at.visibility : all_visible,
                                    tile.sums + b * block_floats};
        at.words += kernels.slot_words;
        if (at.visibility != nullptr) at.visibility += lanes;
        if (list.count == SlotList::capacity) shade_list(kernels, list, tile, unread);
      }
    }
    shade_list(kernels, list, tile, unread);
  }
}

BlockKernels make_block_kernels() {
  return {shade_blocks,
          [](const EncodedSlots& slots, float* out) {
            kernel_table(slots.format)[slots.shader].decode(slots, out);
          },
          add_layer,
          make_finite,
          stream_layer,
          finish_streams,
          scatter_rgb};
}

}  // namespace relume::RELUME_ISA
