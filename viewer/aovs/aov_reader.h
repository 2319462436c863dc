#pragma once

#include <filesystem>

#include "core/scene/channel_map.h"
#include "core/scene/scene.h"
#include "viewer/session/prepare.h"

namespace relume {

/// The samples of an AOV image: one a sub-pixel, unfiltered. Const use is thread-safe.
class AovSamples {
 public:
  /// Reads an image whose sides are multiples of `samples_per_side`. Throws Error(input) naming the
  /// file and the reason: a channel that is missing, values that are not finite, normals or
  /// tangents that are not unit in more than 1 of 100 samples, or coverage between 0 and 1 (the
  /// image was filtered), positions that `camera` does not see where they are, a position beyond
  /// max_coordinate, no samples at all; Error(limit) when the values would take more than 8 GiB.
  AovSamples(const std::filesystem::path& path, const ChannelMap& map, int samples_per_side,
             const Camera& camera);

  int width() const { return width_; }  ///< pixels
  int height() const { return height_; }
  uint64_t sample_count() const { return sample_count_; }
  /// One material for each type of the map, to be appended to the scene that is prepared:
  /// prepared tiles use the types of those.
  void add_materials(Scene& scene) const;
  /// What PrepareParams::source takes; keeps a reference to this.
  SampleSource source() const;

 private:
  /// Where one field of a type comes from, resolved: `channels` index the values of a sub-pixel.
  struct Field {
    std::array<int, 3> channels{-1, -1, -1};
    vec3 constant{0};
    bool is_roughness = false;
    bool is_default_bias = false;
  };
  struct Type {
    const ShaderInfo* shader = nullptr;
    std::optional<float> id;
    std::string missing;        ///< a channel that the file lacks; empty: none
    std::vector<Field> fields;  ///< parallel to shader->fields
  };

  void resolve(const std::filesystem::path& path, const ChannelMap& map);
  int find_type(const float* values) const;
  bool is_hit(const float* values) const;
  void check(const std::filesystem::path& path, const CameraRays& rays);
  SampleTile make_tile(const ViewSampler& view, int index) const;
  bool append(const Type& type, const SampleType& sample_type, const float* values, TypedRows& rows,
              vec3 eye) const;
  const float* values_at(int x, int y) const {
    return &values_[(static_cast<size_t>(y) * width_ * side_ + x) * channels_.size()];
  }

  int side_ = 1;  ///< sub-pixels of a pixel's side
  int width_ = 0;
  int height_ = 0;
  int coverage_ = -1;  ///< index of the channel, or -1
  int id_ = -1;
  std::vector<std::string> channels_;  ///< that are read
  std::vector<Type> types_;
  std::vector<float> values_;  ///< of each sub-pixel, row by row
  uint64_t sample_count_ = 0;
  Bounds bounds_;
};

}  // namespace relume
