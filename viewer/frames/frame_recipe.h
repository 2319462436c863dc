#pragma once

#include <array>
#include <vector>

#include "core/base/label.h"
#include "core/relight/visibility.h"
#include "core/scene/scene.h"
#include "core/simd/instruction_set.h"
#include "shadow/shadow_method.h"

namespace relume {

/// What a frame's file can hold beside light: see docs/frame-format.md.
enum class FrameAov { position, normal, albedo, coverage, visibility, error };

inline constexpr std::array frame_aov_labels = {
    Label<FrameAov>{FrameAov::position, "P"},
    Label<FrameAov>{FrameAov::normal, "N"},
    Label<FrameAov>{FrameAov::albedo, "albedo"},
    Label<FrameAov>{FrameAov::coverage, "coverage"},
    Label<FrameAov>{FrameAov::visibility, "visibility"},
    Label<FrameAov>{FrameAov::error, "error"},
};

/// How a frame was made and what is written of it, beyond what its RelightState knows.
struct FrameRecipe {
  ShadowMethod shadow = ShadowMethod::none;
  VisibilitySource* shadows = nullptr;  ///< asked again for FrameAov::visibility; null: none
  const Scene* scene = nullptr;         ///< what casts the shadows; null: nothing
  InstructionSet instruction_set = InstructionSet::automatic;  ///< as in RelightParams
  std::vector<FrameAov> aovs{};
};

}  // namespace relume
