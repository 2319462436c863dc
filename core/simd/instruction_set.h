#pragma once

#include <array>

#include "core/base/label.h"

namespace relume {

/// Vector instruction sets that kernels are built for. Which exist depends on the processor family
/// this was compiled for; `scalar` always does.
enum class InstructionSet { automatic, scalar, sse42, avx2, avx512 };

inline constexpr std::array instruction_set_labels = {
    Label<InstructionSet>{InstructionSet::automatic, "auto"},
    Label<InstructionSet>{InstructionSet::scalar, "scalar"},
    Label<InstructionSet>{InstructionSet::sse42, "sse4.2"},
    Label<InstructionSet>{InstructionSet::avx2, "avx2"},
    Label<InstructionSet>{InstructionSet::avx512, "avx512"},
};

/// True when this processor can run `set` and this build contains it.
bool is_supported(InstructionSet set);

/// `wanted` when supported, else the best supported one below it; automatic gives the best.
InstructionSet choose_instruction_set(InstructionSet wanted);

}  // namespace relume
