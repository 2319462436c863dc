#pragma once

#include <filesystem>

#include "viewer/frames/frame_layers.h"

namespace relume {

/// True for an EXR file of this size that carries exactly these attributes and can be read to its
/// end: the frame need not be made again. Never throws for what the file holds.
bool is_finished_frame(const std::filesystem::path& path, int width, int height,
                       FrameMetadata metadata);

}  // namespace relume
