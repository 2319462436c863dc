#include "viewer/aovs/aov_reader.h"

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/scene/limits.h"
#include "core/trace/ray_bias.h"
#include "viewer/aovs/fit_camera.h"

namespace relume {
namespace {

/// More samples than this part of them may not look filtered.
constexpr double most_filtered = 0.01;
/// Positions further from their pixels count as unseen there; strands lie on their axes.
constexpr float most_offset_px = 2;
constexpr double most_unseen = 0.1;

/// The channels of a file, found by names that may lack leading layers.
class ChannelFinder {
 public:
  ChannelFinder(std::string place, const std::vector<std::string>& channels)
      : place_(std::move(place)), channels_(channels) {}

  /// The full name, or empty where there is none.
  std::string find(const std::string& name) const {
    std::string found;
    for (const std::string& channel : channels_) {
      if (channel == name) return channel;
      if (!channel.ends_with("." + name)) continue;
      if (!found.empty()) {
        throw input_error(place_, fmt::format("'{}' is ambiguous: {} or {}", name, found, channel),
                          "give the whole name in the channel map");
      }
      found = channel;
    }
    return found;
  }

  /// The full names of a layer's `width` (1 or 3) components, or none.
  std::vector<std::string> find_layer(const std::string& layer, int width) const {
    if (width == 1) {
      for (const char* end : {"", ".V", ".X", ".R", ".Y", ".x", ".r"}) {
        if (std::string name = find(layer + end); !name.empty()) return {name};
      }
      return {};
    }
    for (const std::string_view set : {"XYZ", "RGB", "xyz", "rgb"}) {
      std::vector<std::string> names;
      for (const char component : set) names.push_back(find(layer + "." + component));
      if (std::count(names.begin(), names.end(), "") == 0) return names;
    }
    return {};
  }

  const std::string& place() const { return place_; }

 private:
  std::string place_;
  const std::vector<std::string>& channels_;
};

Error missing_channel(const std::string& place, const std::string& name) {
  return input_error(place, fmt::format("there is no channel or layer '{}'", name),
                     "check --channels (docs/aov-input.md)");
}

int index_of(std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) names.push_back(name);
  return static_cast<int>(std::find(names.begin(), names.end(), name) - names.begin());
}

bool is_unit_field(const SampleField& field) {
  return field.width == 3 && (field.kind == FieldKind::direction || field.kind == FieldKind::axis);
}

/// Half floats give unit vectors to about 1e-3.
bool is_unit(vec3 v) {
  return std::abs(glm::length(v) - 1) < 0.01f;
}

vec3 read_vector(const float* values, const std::array<int, 3>& channels, vec3 constant) {
  if (channels[0] < 0) return constant;
  vec3 v(values[channels[0]]);
  for (int c = 1; c < 3; ++c) {
    if (channels[c] >= 0) v[c] = values[channels[c]];
  }
  return v;
}

/// World units.
float splat_side(const AovHit& hit, const CameraRays& rays) {
  return hit.side_px * rays.footprint_per_depth() * glm::distance(hit.position, rays.eye());
}

/// A GGX lobe of width alpha about the half vector is twice as wide about the mirror direction.
float exponent_of_roughness(float roughness) {
  const float square = roughness * roughness;
  return 1 / std::max(2 * square * square, 1e-5f);
}

}  // namespace

AovSamples::AovSamples(const std::filesystem::path& path, const ChannelMap& map,
                       int samples_per_side, const std::optional<Camera>& camera,
                       uint64_t kept_bytes)
    : side_(samples_per_side) {
  ExrRows file(path);
  if (file.is_deep()) {
    open_deep(path, std::move(file), map, kept_bytes);
  } else {
    open_flat(path, std::move(file), map, kept_bytes);
  }
  camera_ = camera ? *camera : find_camera(path);
  check(path, CameraRays(camera_, width_, height_));
}

void AovSamples::set_size(const std::filesystem::path& path, const ExrRows& file) {
  width_ = file.width() / side_;
  height_ = file.height() / side_;
  if (std::max(width_, height_) > max_image_side) {
    throw limit_error(path.string(), fmt::format("{} x {} pixels", width_, height_),
                      fmt::format("the limit is {0} x {0}", max_image_side));
  }
  const PixelRange sub_pixels = file.data_window();
  data_window_ = {sub_pixels.low / side_, (sub_pixels.high + (side_ - 1)) / side_};
}

void AovSamples::open_flat(const std::filesystem::path& path, ExrRows file, const ChannelMap& map,
                           uint64_t kept_bytes) {
  if (file.width() % side_ != 0 || file.height() % side_ != 0) {
    throw input_error(path.string(),
                      fmt::format("{} x {} pixels are no blocks of {} x {}", file.width(),
                                  file.height(), side_, side_),
                      "give --samples, the sub-pixels of a pixel's side");
  }
  set_size(path, file);
  spp_ = side_ * side_;
  resolve(path.string(), file.channels(), map);
  file.choose(channels_);
  strips_ = std::make_unique<AovStrips>(path, std::move(file), side_, channels_.size(),
                                        AovStrips::Weighing::even, kept_bytes);
}

void AovSamples::open_deep(const std::filesystem::path& path, ExrRows file, const ChannelMap& map,
                           uint64_t kept_bytes) {
  const std::vector<std::string> names = file.channels();
  ChannelMap deep_map = map;
  deep_map.coverage.clear();  // whatever is there is a sample
  resolve(path.string(), names, deep_map);
  const ChannelFinder finder(path.string(), names);
  std::vector<std::string> weight = finder.find_layer("weight", 1);
  const bool is_alpha = weight.empty();
  if (is_alpha) weight = finder.find_layer("A", 1);
  if (weight.empty()) throw missing_channel(path.string(), "weight' or 'A");
  // The weight is the last of each sample's values.
  channels_.push_back(weight.front());
  side_ = 1;
  set_size(path, file);
  file.choose(channels_);
  strips_ = std::make_unique<AovStrips>(
      path, std::move(file), side_, channels_.size(),
      is_alpha ? AovStrips::Weighing::alpha : AovStrips::Weighing::weight, kept_bytes);
}

void AovSamples::visit_pixel(const AovStrip& strip, int x, int y, const VisitSample& visit) const {
  if (x < data_window_.low.x || x >= data_window_.high.x || y < data_window_.low.y ||
      y >= data_window_.high.y)
    return;
  const int row = y - strip.y0;
  if (!strip.first.empty()) {
    const size_t pixel = static_cast<size_t>(row) * width_ + x;
    for (uint64_t i = strip.first[pixel]; i < strip.first[pixel + 1]; ++i) {
      visit(&strip.values[i * channels_.size()], strip.weights[i], vec2(x, y) + 0.5f);
    }
    return;
  }
  const float weight = 1.0f / static_cast<float>(side_ * side_);
  for (int cell = 0; cell < side_ * side_; ++cell) {
    const int sub_x = x * side_ + cell % side_;
    const int sub_y = y * side_ + cell / side_;
    const size_t row_in_strip = static_cast<size_t>(row * side_ + cell / side_);
    const size_t at = row_in_strip * width_ * side_ + sub_x;
    visit(&strip.values[at * channels_.size()], weight,
          (vec2(sub_x, sub_y) + 0.5f) / static_cast<float>(side_));
  }
}

void AovSamples::visit_samples(const VisitSample& visit) const {
  for (int y = data_window_.low.y; y < data_window_.high.y;) {
    const auto strip = strips_->strip(y / tile_size);
    for (; y < std::min(strip->y0 + strip->height, data_window_.high.y); ++y) {
      for (int x = data_window_.low.x; x < data_window_.high.x; ++x)
        visit_pixel(*strip, x, y, visit);
    }
  }
}

AovHit AovSamples::make_hit(const float* values, float weight, vec2 film_px) const {
  const Type& type = types_[static_cast<size_t>(find_type(values))];
  AovHit hit{vec3(0), vec3(0), film_px, std::sqrt(weight)};
  vec3 tangent(0);
  for (size_t i = 0; i < type.fields.size(); ++i) {
    const vec3 v = read_vector(values, type.fields[i].channels, vec3(0));
    const FieldSource source = type.shader->fields[i].source;
    if (source == FieldSource::position) hit.position = v;
    if (source == FieldSource::normal) hit.normal = normalize_or(v, vec3(0));
    if (source == FieldSource::tangent) tangent = normalize_or(v, vec3(0));
  }
  if (hit.normal != vec3(0)) return hit;
  const vec3 wo = normalize_or(camera_.eye - hit.position, vec3(0, 0, 1));
  hit.normal = normalize_or(wo - glm::dot(wo, tangent) * tangent, wo);
  return hit;
}

void AovSamples::visit_hits(const std::function<void(const AovHit&)>& visit) const {
  visit_samples([&](const float* values, float weight, vec2 film_px) {
    if (weight > 0 && is_hit(values)) visit(make_hit(values, weight, film_px));
  });
}

/// From the positions of some samples, spread over the picture.
Camera AovSamples::find_camera(const std::filesystem::path& path) const {
  constexpr size_t most_points = 20000;
  uint64_t hits = 0;
  visit_hits([&](const AovHit&) { ++hits; });
  const uint64_t stride = std::max<uint64_t>(1, hits / most_points);
  std::vector<SeenPoint> points;
  uint64_t index = 0;
  visit_hits([&](const AovHit& hit) {
    if (index++ % stride != 0 || !is_coordinate(hit.position)) return;
    points.push_back({hit.position, hit.film_px});
  });
  if (const auto camera = fit_camera(points, width_, height_)) return *camera;
  throw input_error(path.string(), "the positions do not tell where the camera is",
                    "give --proxy, a scene with the camera of the view");
}

void AovSamples::resolve(const std::string& place, const std::vector<std::string>& names,
                         const ChannelMap& map) {
  const ChannelFinder finder(place, names);
  const auto resolve_channel = [&](const std::string& name) {
    if (name.empty()) return -1;
    const auto found = finder.find_layer(name, 1);
    if (found.empty()) throw missing_channel(place, name);
    return index_of(channels_, found[0]);
  };
  coverage_ = resolve_channel(map.coverage);
  id_ = resolve_channel(map.id);
  for (const ChannelType& wanted : map.types) {
    Type& type = types_.emplace_back();
    type.shader = wanted.shader;
    type.id = wanted.id;
    for (const SampleField& field : wanted.shader->fields) {
      Field& target = type.fields.emplace_back();
      target.constant = vec3(field.initial);
      target.is_default_bias = field.source == FieldSource::bias;
      for (const ChannelSource& source : wanted.fields) {
        const bool is_roughness = source.field == "roughness" && field.name == "exponent";
        if (source.field != field.name && !is_roughness) continue;
        target.is_roughness = is_roughness;
        target.is_default_bias = false;
        target.constant = source.constant;
        if (source.layer.empty()) continue;
        const auto found = finder.find_layer(source.layer, field.width);
        if (found.empty()) type.missing = source.layer;
        for (size_t c = 0; c < found.size(); ++c) {
          target.channels[c] = index_of(channels_, found[c]);
        }
      }
    }
    if (!type.missing.empty() && types_.size() == map.types.size() && !type.id) {
      throw missing_channel(place, type.missing);
    }
  }
}

bool AovSamples::is_hit(const float* values) const {
  if (coverage_ >= 0 && !(values[coverage_] > 0.5f)) return false;
  if (id_ >= 0) return find_type(values) >= 0;
  if (coverage_ >= 0) return true;
  const Type& type = types_.front();
  for (size_t i = 0; i < type.fields.size(); ++i) {
    if (!is_unit_field(type.shader->fields[i])) continue;
    return read_vector(values, type.fields[i].channels, vec3(0)) != vec3(0);
  }
  return true;
}

int AovSamples::find_type(const float* values) const {
  for (size_t t = 0; t < types_.size(); ++t) {
    if (!types_[t].id || (id_ >= 0 && values[id_] == *types_[t].id)) return static_cast<int>(t);
  }
  return -1;
}

void AovSamples::check_sample(const std::filesystem::path& path, const CameraRays& rays,
                              const float* values, vec2 film_px, FilterSigns& signs) {
  if (coverage_ >= 0 && values[coverage_] > 0.02f && values[coverage_] < 0.98f) ++signs.partial;
  if (!is_hit(values)) return;
  const Type& type = types_[static_cast<size_t>(find_type(values))];
  if (!type.missing.empty()) throw missing_channel(path.string(), type.missing);
  for (size_t i = 0; i < type.fields.size(); ++i) {
    const SampleField& field = type.shader->fields[i];
    const vec3 v = read_vector(values, type.fields[i].channels, vec3(0));
    if (!is_finite(v) || (field.source == FieldSource::position && !is_coordinate(v))) {
      const vec2 sub_px = glm::floor(film_px * static_cast<float>(side_));
      throw input_error(path.string(),
                        fmt::format("the {} of sub-pixel ({}, {}) is not finite or too large",
                                    field.name, sub_px.x, sub_px.y),
                        "render it again");
    }
    if (is_unit_field(field) && !is_unit(v)) ++signs.not_unit;
    if (field.source != FieldSource::position) continue;
    bounds_.extend(v);
    const CameraRays::Projection seen = rays.project(v);
    if (!(seen.depth > 0) || glm::distance(seen.film_px, film_px) > most_offset_px) ++signs.unseen;
  }
  ++sample_count_;
}

void AovSamples::check(const std::filesystem::path& path, const CameraRays& rays) {
  FilterSigns signs;
  visit_samples([&](const float* values, float, vec2 film_px) {
    check_sample(path, rays, values, film_px, signs);
  });
  spp_ = std::max(spp_, static_cast<int>(strips_->most_samples()));
  const auto hits = static_cast<double>(sample_count_);
  if (sample_count_ == 0) {
    throw input_error(path.string(), "no sub-pixel holds a sample", "check --channels");
  }
  if (static_cast<double>(signs.not_unit) > most_filtered * hits) {
    throw input_error(path.string(),
                      fmt::format("{} of {} normals or tangents are not unit vectors: the image "
                                  "was filtered",
                                  signs.not_unit, sample_count_),
                      "render one sample a sub-pixel without a pixel filter");
  }
  if (static_cast<double>(signs.partial) > most_filtered * hits) {
    throw input_error(
        path.string(),
        fmt::format("{} sub-pixels are covered in part: the image was filtered", signs.partial),
        "render one sample a sub-pixel without a pixel filter");
  }
  if (static_cast<double>(signs.unseen) > most_unseen * hits) {
    throw input_error(path.string(),
                      fmt::format("{} of {} positions are not where the proxy's camera sees them",
                                  signs.unseen, sample_count_),
                      "check the camera, the axes and units of --proxy, and --samples");
  }
}

void AovSamples::add_materials(Scene& scene) const {
  for (const Type& type : types_) {
    Material& material = scene.materials.emplace_back();
    material.name = fmt::format("aov-{}", type.shader->name);
    const auto found = std::find(scene.shaders.begin(), scene.shaders.end(), type.shader);
    material.shader = static_cast<int>(found - scene.shaders.begin());
  }
}

SampleSource AovSamples::source() const {
  return {[this](const ViewSampler& view, int index) { return make_tile(view, index); }, bounds_};
}

bool AovSamples::append(const Type& type, const SampleType& sample_type, const float* values,
                        TypedRows& rows, vec3 eye, float least_bias) const {
  const size_t start = rows.values.size();
  vec3 position(0);
  for (size_t i = 0; i < type.fields.size(); ++i) {
    const SampleField& field = type.shader->fields[i];
    const Field& from = type.fields[i];
    vec3 v = read_vector(values, from.channels, from.constant);
    if (field.source == FieldSource::position) position = v;
    if (from.is_default_bias) v = vec3(surface_bias(position, position, position));
    if (field.source == FieldSource::bias) v = glm::max(v, vec3(least_bias));
    if (from.is_roughness) v = vec3(exponent_of_roughness(v.x));
    if (field.source == FieldSource::material) {
      v = glm::clamp(v, vec3(field.low), vec3(field.high));
    }
    if (is_unit_field(field)) {
      // Vectors that are unit to a few bits stay as they are.
      if (std::abs(glm::dot(v, v) - 1) > 1e-5f) v = normalize_or(v, vec3(0));
      if (v == vec3(0)) {
        rows.values.resize(start);
        return false;
      }
      if (field.source == FieldSource::normal && glm::dot(v, eye - position) < 0) v = -v;
    }
    for (int c = 0; c < field.width; ++c) rows.values.push_back(v[c]);
  }
  CHECK_MSG(rows.values.size() - start == static_cast<size_t>(sample_type.width), "width {}",
            sample_type.width);
  return true;
}

SampleTile AovSamples::make_tile(const ViewSampler& view, int index) const {
  const TileRectangle place = tile_rectangle(view, index);
  SampleTile tile;
  tile.x0 = place.x0;
  tile.y0 = place.y0;
  tile.width = place.width;
  tile.height = place.height;
  tile.types.resize(view.types.types.size());
  for (TypedRows& rows : tile.types) rows.first.push_back(0);
  const size_t first_material = view.types.type_of_material.size() - types_.size();
  const CameraRays rays(camera_, width_, height_);
  const auto strip = strips_->strip(tile.y0 / tile_size);
  for (int pixel = 0; pixel < tile.pixel_count(); ++pixel) {
    visit_pixel(*strip, tile.x0 + pixel % tile.width, tile.y0 + pixel / tile.width,
                [&](const float* values, float weight, vec2 film_px) {
                  if (!(weight > 0) || !is_hit(values)) return;
                  const float least_bias =
                      casts_own_shadows_ ? splat_side(make_hit(values, weight, film_px), rays) : 0;
                  const auto type = static_cast<size_t>(find_type(values));
                  const uint16_t sample_type = view.types.type_of_material[first_material + type];
                  TypedRows& rows = tile.types[sample_type];
                  const bool is_kept = append(types_[type], view.types.types[sample_type], values,
                                              rows, view.scene->camera.eye, least_bias);
                  if (is_kept) rows.weights.push_back(weight);
                });
    for (TypedRows& rows : tile.types) rows.first.push_back(static_cast<uint32_t>(rows.rows()));
  }
  return tile;
}

}  // namespace relume
