#pragma once

#include <filesystem>

#include "core/scene/channel_map.h"
#include "core/scene/scene.h"
#include "viewer/aovs/aov_strips.h"
#include "viewer/session/prepare.h"

namespace relume {

/// A sample as a place.
struct AovHit {
  vec3 position;  ///< world
  vec3 normal;    ///< unit; of strands the direction across them that faces the eye
  vec2 film_px;   ///< pixels
  float side_px;  ///< of the square in the picture that the sample stands for
};

/// The samples of an AOV image: one a sub-pixel, unfiltered, or those of a deep image, each with
/// its weight. They stay in the file and are read by rows of tiles, once for each pass over the
/// picture, so that memory does not grow with it. Const use is thread-safe.
class AovSamples {
 public:
  static constexpr uint64_t default_kept_bytes = uint64_t{512} << 20;

  /// Reads a deep image, or a flat one whose sides are multiples of `samples_per_side`. Throws
  /// Error(input) naming the file and the reason: a channel that is missing, values that are not
  /// finite, normals or tangents that are not unit in more than 1 of 100 samples, or coverage
  /// between 0 and 1 (the image was filtered), positions that `camera` does not see where they are
  /// (none given: one is sought that does), a position beyond max_coordinate, no samples at all,
  /// weights of a deep pixel that sum to more than 1; Error(limit) when the deep samples of a row
  /// of tiles would take more than 8 GiB or a deep pixel has more than 1024 samples. Values that
  /// were read stay in memory up to `kept_bytes`; rows of tiles in use come on top.
  AovSamples(const std::filesystem::path& path, const ChannelMap& map, int samples_per_side,
             const std::optional<Camera>& camera, uint64_t kept_bytes = default_kept_bytes);

  int width() const { return width_; }  ///< pixels
  int height() const { return height_; }
  uint64_t sample_count() const { return sample_count_; }
  /// Of the view: the one given, or the one that sees the positions where they are.
  const Camera& camera() const { return camera_; }
  /// Calls visit(hit) for each sample, pixel by pixel: a pass over the file.
  void visit_hits(const std::function<void(const AovHit&)>& visit) const;
  /// Shadow rays leave the square of their sample, which casts shadows itself: biases become at
  /// least its side. Before source() is used.
  void cast_own_shadows() { casts_own_shadows_ = true; }
  /// The most samples that a pixel may have, [1, 1024].
  int spp() const { return spp_; }
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
  /// What filtered or misplaced samples give away.
  struct FilterSigns {
    uint64_t not_unit = 0;
    uint64_t partial = 0;
    uint64_t unseen = 0;
  };
  struct Type {
    const ShaderInfo* shader = nullptr;
    std::optional<float> id;
    std::string missing;        ///< a channel that the file lacks; empty: none
    std::vector<Field> fields;  ///< parallel to shader->fields
  };

  /// One sample of a pixel. `film_px`: where it lies, in pixels.
  using VisitSample = std::function<void(const float* values, float weight, vec2 film_px)>;

  void open_flat(const std::filesystem::path& path, ExrRows file, const ChannelMap& map,
                 uint64_t kept_bytes);
  void open_deep(const std::filesystem::path& path, ExrRows file, const ChannelMap& map,
                 uint64_t kept_bytes);
  void set_size(const std::filesystem::path& path, const ExrRows& file);
  void visit_pixel(const AovStrip& strip, int x, int y, const VisitSample& visit) const;
  void visit_samples(const VisitSample& visit) const;
  void resolve(const std::string& place, const std::vector<std::string>& names,
               const ChannelMap& map);
  int find_type(const float* values) const;
  bool is_hit(const float* values) const;
  AovHit make_hit(const float* values, float weight, vec2 film_px) const;
  Camera find_camera(const std::filesystem::path& path) const;
  void check(const std::filesystem::path& path, const CameraRays& rays);
  void check_sample(const std::filesystem::path& path, const CameraRays& rays, const float* values,
                    vec2 film_px, FilterSigns& signs);
  SampleTile make_tile(const ViewSampler& view, int index) const;
  bool append(const Type& type, const SampleType& sample_type, const float* values, TypedRows& rows,
              vec3 eye, float least_bias) const;
  int side_ = 1;  ///< sub-pixels of a pixel's side
  int width_ = 0;
  int height_ = 0;
  PixelRange data_window_;  ///< pixels that may hold samples
  int coverage_ = -1;       ///< index of the channel, or -1
  int id_ = -1;
  std::vector<std::string> channels_;  ///< that are read
  std::vector<Type> types_;
  std::unique_ptr<AovStrips> strips_;
  int spp_ = 1;
  Camera camera_;
  bool casts_own_shadows_ = false;
  uint64_t sample_count_ = 0;
  Bounds bounds_;
};

}  // namespace relume
