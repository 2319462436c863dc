#pragma once

/// Relume as a library: load or prepare a view, relight it, compare pictures. This header is all of
/// it and needs nothing but the standard library (C++17). Names of methods, shadows and formats are
/// the labels of the command line; docs/library.md has examples in C++ and Python.
///
/// Failures of the outside world throw relume::api::Error. Objects may be used from one thread at a
/// time each, a Cache from many; the work inside uses all cores.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#define RELUME_API __attribute__((visibility("default")))

namespace relume::api {

/// What went wrong with a file, a name or a limit, in one line with the mend.
class RELUME_API Error : public std::runtime_error {
 public:
  /// The values are the program's exit codes.
  enum class Kind { usage = 2, input = 3, limit = 4, output = 5, cancelled = 130 };

  Error(Kind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
  ~Error() override;

  Kind kind() const { return kind_; }

 private:
  Kind kind_;
};

using Vector = std::array<float, 3>;

/// A light, with the keys and the meaning of a light in a scene file (docs/scene-format.md).
struct Light {
  std::string name = "light";  ///< without dots
  std::string type = "point";  ///< point, spot or directional
  Vector position{0, 0, 0};    ///< world
  Vector direction{0, -1, 0};  ///< world, the way the light travels
  float inner_angle_deg = 20;  ///< half angle of a spot's full cone
  float outer_angle_deg = 30;  ///< half angle where a spot ends
  bool falloff = true;         ///< inverse-square
  float range = 0;             ///< world units; 0: has no end
  Vector color{1, 1, 1};       ///< scene-linear, >= 0
  float gain = 1;              ///< >= 0
  bool mute = false;
  bool casts_shadow = true;
};

/// Pixels that something else owns: `channels` interleaved floats a pixel, rows top to bottom.
struct ImageView {
  const float* pixels = nullptr;
  int width = 0;  ///< pixels
  int height = 0;
  int channels = 0;
};

/// Pixels of its own.
struct Image {
  int width = 0;  ///< pixels
  int height = 0;
  int channels = 0;
  std::vector<float> pixels;

  ImageView view() const { return {pixels.data(), width, height, channels}; }
};

/// How a scene becomes records, as the flags of `relume prepare` of the same names.
struct PrepareSettings {
  std::string method = "strong-kmeans";
  int records = 0;            ///< k of each pixel; 0: 8, or at most 16 under a budget
  float average_records = 0;  ///< budget; 0: none
  float target_error = 0;     ///< budget; 0: none
  int spp = 25;               ///< samples a pixel, [1, 1024]
  std::string format;         ///< exact, compact, ...; empty: chosen
  int members = 0;            ///< 255 for the shadows `members`, `coverage` and `auto`
  bool predict_error = false;
  int width = 0;  ///< pixels; 0: the scene's
  int height = 0;
  uint64_t seed = 0;
};

/// Told of each stage how far it is, [0, 1], at most about ten times a second. Returning false
/// stops: the call then throws an Error of kind `cancelled`.
using Progress = std::function<bool(const std::string& stage, double fraction)>;

/// The prepared records of one view. Immutable; copies share the data. Thread-safe.
class RELUME_API Cache {
 public:
  /// Samples and reduces a scene: a built-in label, a scene file or a glTF.
  static Cache prepare(const std::string& scene, const PrepareSettings& settings = {},
                       const Progress& progress = {});
  /// Maps a .relume file.
  static Cache open(const std::string& path);

  /// Writes a .relume file; nothing appears at `path` before it is complete.
  void save(const std::string& path) const;

  int width() const;  ///< pixels
  int height() const;
  std::string scene() const;   ///< its name
  std::string method() const;  ///< label
  int spp() const;
  uint64_t sample_count() const;
  uint64_t record_count() const;
  uint64_t hash() const;              ///< equal hashes stand for equal caches
  std::vector<Light> lights() const;  ///< of the scene
  Image coverage() const;             ///< one channel, [0, 1]
  Image emission() const;  ///< RGB that materials send out by themselves, whatever the lights
  Image predicted_error() const;  ///< one channel, in the picture's units; Error where unknown

 private:
  friend class Relighter;
  struct Data;
  explicit Cache(std::shared_ptr<Data> data);
  std::shared_ptr<Data> data_;
};

/// One picture that follows its lights. A moved light costs its own layer, a changed gain or colour
/// a weighted sum.
class RELUME_API Relighter {
 public:
  /// `shadow`: none, ray, members, coverage, opacity, volume or auto. All but `none` load the scene
  /// that an opened cache was made from.
  explicit Relighter(const Cache& cache, const std::string& shadow = "ray");
  ~Relighter();
  Relighter(Relighter&&) noexcept;
  Relighter& operator=(Relighter&&) noexcept;

  /// Brings the frame up to date. The same bits for any number of threads.
  void relight(const std::vector<Light>& lights);

  /// RGB, scene-linear, finite: always the last relight()'s. The pixels stay where they are as long
  /// as this lives.
  ImageView frame() const;
  /// What light i adds to the frame, RGB; these and Cache::emission() sum to the frame.
  Image layer(size_t i) const;
  /// Writes .exr or .png (docs/frame-format.md).
  void save(const std::string& path) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// How far an image is from a reference.
struct ImageError {
  double error_image = 0;    ///< TR2007-600 eq. 7: mean over pixels of the RMS over RGB
  double error_covered = 0;  ///< the same over pixels that are not black in both
  double rmse = 0;
  double relative_mse = 0;
  double max_error = 0;  ///< largest RMS of a pixel
};

/// Both of the same size, with three channels.
RELUME_API ImageError compare(const ImageView& image, const ImageView& reference);

/// RGB of an EXR, PNG or other image, scene-linear.
RELUME_API Image read_image(const std::string& path);

/// A light file or a scene file with world positions, as `relume render --lights` takes it.
RELUME_API std::vector<Light> load_lights(const std::string& path);
RELUME_API void save_lights(const std::string& path, const std::vector<Light>& lights);

/// Threads that the process uses; 0: all. Call it before anything else.
RELUME_API void set_threads(int threads);

/// For instance "0.1.0".
RELUME_API std::string version();

}  // namespace relume::api
