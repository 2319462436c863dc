#include "viewer/library/relume.h"

#include <fmt/format.h>

#include <mutex>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/parallel.h"
#include "core/image/image_io.h"
#include "core/image/metrics.h"
#include "core/relight/emission.h"
#include "core/scene/io/load_scene.h"
#include "viewer/commands/relight_input.h"
#include "viewer/commands/version.h"
#include "viewer/session/save_frame.h"

namespace relume::api {
namespace {

constexpr uint64_t max_light_file_bytes = uint64_t{64} << 20;

/// Runs `work` and turns the program's errors into the library's.
template <class Work>
auto guarded(const Work& work) {
  try {
    return work();
  } catch (const relume::Error& error) {
    throw Error(static_cast<Error::Kind>(error.kind()), error.what());
  }
}

/// The enumerator of a label. Throws Error(usage) that lists them.
template <class E, size_t N>
E parse_label(const char* what, const std::string& text, const std::array<Label<E>, N>& labels) {
  const std::optional<E> found = value_of(labels, text);
  if (found) return *found;
  throw relume::Error(ErrorKind::usage,
                      fmt::format("{} '{}' is not one of {}", what, text, label_list(labels)));
}

vec3 to_vec(const Vector& v) {
  return {v[0], v[1], v[2]};
}
Vector from_vec(vec3 v) {
  return {v.x, v.y, v.z};
}

relume::Light to_internal(const Light& from) {
  relume::Light light;
  light.name = from.name;
  light.type = parse_label("light type", from.type, light_type_labels);
  light.position = to_vec(from.position);
  light.direction = to_vec(from.direction);
  light.inner_angle_deg = from.inner_angle_deg;
  light.outer_angle_deg = from.outer_angle_deg;
  light.falloff = from.falloff;
  light.range = from.range;
  light.color = to_vec(from.color);
  light.gain = from.gain;
  light.mute = from.mute;
  light.casts_shadow = from.casts_shadow;
  return light;
}

Light from_internal(const relume::Light& from) {
  Light light;
  light.name = from.name;
  light.type = label_of(light_type_labels, from.type);
  light.position = from_vec(from.position);
  light.direction = from_vec(from.direction);
  light.inner_angle_deg = from.inner_angle_deg;
  light.outer_angle_deg = from.outer_angle_deg;
  light.falloff = from.falloff;
  light.range = from.range;
  light.color = from_vec(from.color);
  light.gain = from.gain;
  light.mute = from.mute;
  light.casts_shadow = from.casts_shadow;
  return light;
}

std::vector<relume::Light> to_internal(const std::vector<Light>& from) {
  std::vector<relume::Light> lights;
  for (const Light& light : from) lights.push_back(to_internal(light));
  return lights;
}

std::vector<Light> from_internal(const std::vector<relume::Light>& from) {
  std::vector<Light> lights;
  for (const relume::Light& light : from) lights.push_back(from_internal(light));
  return lights;
}

Image from_internal(relume::Image image) {
  return {image.width, image.height, image.channels, std::move(image.pixels)};
}

relume::Image to_internal(const ImageView& view) {
  if (view.channels < 3 || view.width < 1 || view.height < 1) {
    throw relume::Error(ErrorKind::usage, "pictures to compare have three channels and pixels");
  }
  relume::Image image(view.width, view.height, view.channels);
  std::copy_n(view.pixels, image.pixels.size(), image.pixels.begin());
  return image;
}

void require_range(const char* what, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw relume::Error(ErrorKind::usage,
                      fmt::format("{}: {} is not within [{}, {}]", what, value, low, high));
}

PrepareOptions to_internal(const PrepareSettings& settings) {
  require_range("spp", settings.spp, 1, 1024);
  require_range("records", settings.records, 0, 64);
  require_range("average_records", settings.average_records, 0, 64);
  require_range("target_error", settings.target_error, 0, 1);
  require_range("members", settings.members, 0, max_members);
  require_range("width", settings.width, 0, 16384);
  require_range("height", settings.height, 0, 16384);
  PrepareOptions options;
  options.spp = settings.spp;
  options.method = parse_label("method", settings.method, reduction_method_labels);
  if (settings.records > 0) options.records = settings.records;
  options.budget = {.average_records = settings.average_records,
                    .target_error = settings.target_error};
  if (settings.members > 0) options.members = settings.members;
  options.predict_error = settings.predict_error;
  if (!settings.format.empty()) {
    options.format = parse_label("format", settings.format, cache_format_labels);
  }
  options.width = settings.width;
  options.height = settings.height;
  return options;
}

}  // namespace

Error::~Error() = default;

struct Cache::Data {
  RelightInput input;
  std::string path;  ///< of the file it was opened from; empty: prepared
  std::mutex mutex;  ///< over the loading of the scene

  const RelightCache& cache() const { return *input.cache; }

  /// Loads the scene that casts the shadows, if it is not there yet.
  void load_scene() {
    const std::scoped_lock lock(mutex);
    if (input.tracer) return;
    RelightInput loaded = open_input(path, {}, true, {.quiet = true});
    input.scene = std::move(loaded.scene);
    input.tracer = std::move(loaded.tracer);
  }
};

Cache::Cache(std::shared_ptr<Data> data) : data_(std::move(data)) {}

Cache Cache::prepare(const std::string& scene, const PrepareSettings& settings,
                     const Progress& progress) {
  return guarded([&] {
    if (is_cache_path(scene)) {
      throw relume::Error(ErrorKind::usage, scene + ": is a cache; open it");
    }
    OpenHooks hooks;
    hooks.progress = [&progress](const std::string& stage, double fraction, double) {
      return !progress || progress(stage, fraction);
    };
    auto data = std::make_shared<Data>();
    data->input = open_input(scene, to_internal(settings), true,
                             {.seed = settings.seed, .quiet = true}, hooks);
    return Cache(std::move(data));
  });
}

Cache Cache::open(const std::string& path) {
  return guarded([&] {
    if (!is_cache_path(path)) {
      throw relume::Error(ErrorKind::usage, path + ": is no .relume cache; prepare it");
    }
    auto data = std::make_shared<Data>();
    data->input = open_input(path, {}, false, {.quiet = true});
    data->path = path;
    return Cache(std::move(data));
  });
}

void Cache::save(const std::string& path) const {
  guarded([&] { write_file_atomic(path, data_->cache().bytes()); });
}

int Cache::width() const {
  return data_->cache().info().width;
}
int Cache::height() const {
  return data_->cache().info().height;
}
std::string Cache::scene() const {
  return data_->cache().info().scene_name;
}
std::string Cache::method() const {
  return data_->cache().info().method;
}
int Cache::spp() const {
  return data_->cache().info().spp;
}
uint64_t Cache::sample_count() const {
  return data_->cache().info().sample_count;
}
uint64_t Cache::record_count() const {
  return data_->cache().info().record_count;
}
uint64_t Cache::hash() const {
  return data_->cache().hash();
}
std::vector<Light> Cache::lights() const {
  return from_internal(data_->cache().info().lights);
}
Image Cache::coverage() const {
  return {width(), height(), 1, data_->cache().coverage()};
}

Image Cache::emission() const {
  return guarded([&] { return from_internal(emission_image(data_->cache())); });
}

Image Cache::predicted_error() const {
  if (!data_->cache().info().has_predicted_error) {
    throw Error(Error::Kind::usage,
                "method " + method() + " predicted no errors; prepare with predict_error");
  }
  return {width(), height(), 1, data_->cache().predicted_error()};
}

struct Relighter::Data {
  explicit Data(std::shared_ptr<Cache::Data> prepared)
      : cache(std::move(prepared)), state(make_relight_state(cache->cache())) {}

  std::shared_ptr<Cache::Data> cache;
  ShadowMethod shadow = ShadowMethod::none;
  std::unique_ptr<VisibilitySource> shadows;
  RelightState state;
};

Relighter::Relighter(const Cache& cache, const std::string& shadow)
    : data_(std::make_unique<Data>(cache.data_)) {
  guarded([&] {
    data_->shadow = parse_label("shadow", shadow, shadow_method_labels);
    if (data_->shadow == ShadowMethod::none) return;
    cache.data_->load_scene();
    data_->shadows = make_shadow(data_->shadow, *cache.data_->input.tracer, cache.data_->cache());
  });
}

Relighter::~Relighter() = default;
Relighter::Relighter(Relighter&&) noexcept = default;
Relighter& Relighter::operator=(Relighter&&) noexcept = default;

void Relighter::relight(const std::vector<Light>& lights) {
  guarded([&] { relume::relight(data_->state, to_internal(lights), data_->shadows.get()); });
}

ImageView Relighter::frame() const {
  const relume::Image& frame = data_->state.frame;
  return {frame.pixels.data(), frame.width, frame.height, frame.channels};
}

Image Relighter::layer(size_t i) const {
  if (i >= data_->state.lights.size()) {
    throw Error(Error::Kind::usage, fmt::format("there is no light {}: the frame has {}", i,
                                                data_->state.lights.size()));
  }
  return guarded([&] { return from_internal(weighted_layer(data_->state, i)); });
}

void Relighter::save(const std::string& path) const {
  guarded([&] {
    save_frame(data_->state,
               {.exposure = data_->cache->cache().info().exposure, .curve = default_curve()}, path,
               {.shadow = data_->shadow,
                .shadows = data_->shadows.get(),
                .scene = data_->cache->input.scene.get()});
  });
}

ImageError compare(const ImageView& image, const ImageView& reference) {
  return guarded([&] {
    const relume::ImageError error = compare_images(to_internal(image), to_internal(reference));
    return ImageError{error.error_image, error.error_covered, error.rmse, error.relative_mse,
                      error.max_error};
  });
}

Image read_image(const std::string& path) {
  return guarded([&] { return from_internal(relume::read_image(path)); });
}

std::vector<Light> load_lights(const std::string& path) {
  return guarded([&] {
    return from_internal(parse_lights(read_text_file(path, max_light_file_bytes), path));
  });
}

void save_lights(const std::string& path, const std::vector<Light>& lights) {
  guarded([&] { write_file_atomic(path, format_lights(to_internal(lights))); });
}

void set_threads(int threads) {
  set_thread_count(threads);
}

std::string version() {
  return relume_version;
}

}  // namespace relume::api
