#pragma once

#include "core/image/image.h"
#include "core/samples/sample_scene.h"
#include "viewer/study/shadow_lights.h"
#include "viewer/study/trial_log.h"

namespace relume {

/// A part of a picture in whole tiles, pixels.
struct StudyWindow {
  int x0 = 0;
  int y0 = 0;
  int width = 0;
  int height = 0;

  bool contains(const TileRectangle& tile) const {
    return tile.x0 >= x0 && tile.y0 >= y0 && tile.x0 < x0 + width && tile.y0 < y0 + height;
  }
};

/// The window of about `size_px` pixels a side around pixel `center`, cut to the picture;
/// size_px <= 0: the whole picture.
StudyWindow make_window(int size_px, vec2 center, int width, int height);

/// What a window looks like when every sample traces its own ray.
struct ShadowTruth {
  std::vector<float> covered;                          ///< per pixel of the window: 1 or 0
  std::vector<std::vector<std::vector<float>>> steps;  ///< per light and step: visibility by pixel
  std::vector<Image> frames;  ///< per light, at its first place: the shadowed picture
};

/// All samples of `view` within the window, each with its own ray to every place of every light:
/// spp * pixels * places rays. Visibility is the mean over the samples that hit, unshaded, 0 for
/// those that the light cannot light (see LitVisibility). All threads, bit-equal for any number.
/// Tiles that `log` holds are taken from it, the others are added to it, some ten bytes a number.
ShadowTruth trace_truth(const ViewSampler& view, const StudyWindow& window,
                        std::span<const StudyLight> lights, TrialLog& log,
                        const ProgressCallback& progress);

}  // namespace relume
