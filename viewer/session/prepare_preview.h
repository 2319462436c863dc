#pragma once

#include <functional>
#include <mutex>

#include "core/image/image.h"
#include "core/samples/sample_scene.h"
#include "core/scene/light.h"

namespace relume {

/// A first picture while a scene is being prepared: tiles are shaded as they come, with one traced
/// shadow ray a pixel and light. Rough, and gone when the session is there.
class PreparePreview {
 public:
  /// `notify`, which may be empty, is called from working threads now and then when there are new
  /// tiles.
  explicit PreparePreview(std::function<void()> notify = {}) : notify_(std::move(notify)) {}

  /// Shades the records of one tile of `view` under the scene's lights. Any thread.
  void add_tile(const ViewSampler& view, const SampleTile& records);

  /// Copies the picture so far, scene-linear RGB, black where nothing came yet, and the scene's
  /// exposure in stops; false when nothing is new.
  bool take(Image& image, float& exposure);

 private:
  const std::function<void()> notify_;
  std::mutex mutex_;  // guards the members below
  Image image_;
  float exposure_ = 0;
  bool fresh_ = false;
};

}  // namespace relume
