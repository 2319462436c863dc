#pragma once

#include <filesystem>
#include <optional>

#include "core/scene/light.h"
#include "viewer/frames/frame_recipe.h"
#include "viewer/session/prepare_options.h"

namespace relume {

/// What make_frame_metadata() left in a frame's file, read back.
struct FrameHeader {
  std::string scene_file;     ///< path or built-in label
  std::string cache_hash;     ///< RelightCache::hash() in hexadecimal
  std::string geometry_hash;  ///< geometry_hash() in hexadecimal; empty: no shadows
  PrepareOptions prepare;     ///< as far as a cache knows how it was made
  uint64_t seed = 0;
  ShadowMethod shadow = ShadowMethod::none;
  InstructionSet instruction_set = InstructionSet::automatic;
  std::vector<FrameAov> aovs;
  std::vector<Light> lights;
  std::vector<std::string> channels;  ///< of the file
  int width = 0;                      ///< pixels
  int height = 0;
};

/// Throws Error(input) for a file that is no frame of this program and version, or whose attributes
/// do not make sense.
FrameHeader read_frame_header(const std::filesystem::path& path);

}  // namespace relume
