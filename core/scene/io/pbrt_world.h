#pragma once

#include <map>
#include <optional>
#include <set>

#include "core/math/vec.h"
#include "core/scene/camera.h"
#include "core/scene/io/pbrt_text.h"
#include "core/scene/light.h"

namespace relume {

using dmat4 = glm::dmat4;

/// What holds at a point of a pbrt scene besides its material.
struct PbrtState {
  dmat4 world_from_local{1};  ///< the current transform
  vec3 emission{0};           ///< radiance of the AreaLightSource above, if any
  int material = 0;
};

/// The statements of a pbrt scene that are neither shapes nor materials: transforms, attributes,
/// camera, film and lights.
class PbrtWorld {
 public:
  explicit PbrtWorld(const std::filesystem::path& path) : reader_(path) {}

  /// The next statement that is not dealt with here, or nothing at the end.
  std::optional<PbrtStatement> next();

  PbrtState& state() { return state_; }
  /// True once a camera was met that sees the axes left-handed.
  bool is_mirrored() const { return is_mirrored_; }
  /// From the file's axes to ours.
  dmat4 ours_from_file() const;

  // Complete after the last statement, in our axes.
  std::optional<Camera> camera() const;
  int width() const { return width_; }    ///< pixels
  int height() const { return height_; }  ///< pixels
  const std::vector<Light>& lights() const { return lights_; }

  /// What is left out, in words; each once.
  const std::set<std::string>& notes() const { return notes_; }

 private:
  bool apply(const PbrtStatement& statement);
  bool transform(const PbrtStatement& statement);
  bool attribute(const PbrtStatement& statement);
  void begin_world();
  void push() { stack_.push_back(state_); }
  void pop(const PbrtStatement& statement);
  void read_camera(const PbrtStatement& statement);
  void read_film(const PbrtParameters& parameters);
  void read_light(const PbrtStatement& statement);
  void read_area_light(const PbrtStatement& statement);
  void add_light(Light light, const PbrtParameters& parameters, std::string_view power);
  vec3 read_strength(const PbrtParameters& parameters, std::string_view power);

  PbrtReader reader_;
  PbrtState state_;
  std::vector<PbrtState> stack_;
  std::map<std::string, dmat4> systems_;
  bool is_transform_active_ = true;
  bool is_mirrored_ = false;
  std::optional<dmat4> world_from_camera_;
  double fov_deg_ = 90;  ///< of the shorter side
  int width_ = 1280;
  int height_ = 720;
  std::vector<Light> lights_;
  std::set<std::string> notes_;
};

}  // namespace relume
