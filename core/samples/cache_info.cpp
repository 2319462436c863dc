#include <fmt/format.h>
#include <xxhash.h>

#include <cstring>

#include "core/base/error.h"
#include "core/samples/cache_format.h"

namespace relume {
namespace {

constexpr uint64_t max_text_bytes = uint64_t{64} << 20;

/// Appends values to a byte string.
class Writer {
 public:
  static constexpr bool reading = false;
  template <class T>
  void value(const T& x) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto* p = reinterpret_cast<const std::byte*>(&x);
    bytes.insert(bytes.end(), p, p + sizeof(T));
  }
  void text(const std::string& s) {
    value(static_cast<uint64_t>(s.size()));
    const auto* p = reinterpret_cast<const std::byte*>(s.data());
    bytes.insert(bytes.end(), p, p + s.size());
  }
  std::vector<std::byte> bytes;
};

/// Takes values from a byte string that is not trusted.
class Reader {
 public:
  static constexpr bool reading = true;
  Reader(std::span<const std::byte> bytes, const std::string& place)
      : bytes_(bytes), place_(place) {}

  template <class T>
  void value(T& x) {
    std::memcpy(&x, take(sizeof(T)).data(), sizeof(T));
  }
  void text(std::string& s) {
    uint64_t size = 0;
    value(size);
    if (size > max_text_bytes) fail("a text is too long");
    const auto part = take(size);
    s.assign(reinterpret_cast<const char*>(part.data()), part.size());
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw input_error(place_, "corrupt cache: " + what, "prepare the scene again");
  }
  bool at_end() const { return bytes_.empty(); }

 private:
  std::span<const std::byte> take(uint64_t size) {
    if (size > bytes_.size()) fail("the header ends early");
    const auto part = bytes_.first(size);
    bytes_ = bytes_.subspan(size);
    return part;
  }
  std::span<const std::byte> bytes_;
  const std::string& place_;
};

// One description of each structure serves reading and writing. bool and enum go as one byte each.

template <class Archive, class Flag>
void visit_byte(Archive& archive, Flag& flag, uint8_t count) {
  uint8_t byte = static_cast<uint8_t>(flag);
  archive.value(byte);
  if constexpr (Archive::reading) {
    if (byte >= count) archive.fail("a label is unknown");
    flag = static_cast<Flag>(byte);
  }
}

template <class Archive, class LightRef>
void visit_light(Archive& archive, LightRef& light) {
  archive.text(light.name);
  visit_byte(archive, light.type, static_cast<uint8_t>(light_type_labels.size()));
  archive.value(light.position);
  archive.value(light.direction);
  archive.value(light.inner_angle_deg);
  archive.value(light.outer_angle_deg);
  visit_byte(archive, light.falloff, 2);
  archive.value(light.range);
  archive.value(light.color);
  archive.value(light.gain);
  visit_byte(archive, light.mute, 2);
  visit_byte(archive, light.casts_shadow, 2);
}

template <class Archive, class InfoRef>
void visit_plain(Archive& archive, InfoRef& info) {
  archive.value(info.width);
  archive.value(info.height);
  archive.value(info.camera.eye);
  archive.value(info.camera.target);
  archive.value(info.camera.up);
  archive.value(info.camera.fov_y_deg);
  archive.value(info.bounds.low);
  archive.value(info.bounds.high);
  visit_byte(archive, info.format, static_cast<uint8_t>(cache_format_labels.size()));
  archive.text(info.method);
  archive.value(info.records);
  archive.value(info.spp);
  archive.value(info.seed);
  archive.value(info.sample_count);
  archive.value(info.record_count);
  archive.text(info.scene_name);
  archive.text(info.scene_file);
  archive.text(info.scene_text);
  archive.value(info.exposure);
  archive.value(info.average_records);
  archive.value(info.target_error);
  visit_byte(archive, info.has_predicted_error, 2);
  visit_byte(archive, info.has_footprints, 2);
  visit_byte(archive, info.has_members, 2);
  visit_byte(archive, info.has_emission, 2);
  visit_light(archive, info.representative_low);
  visit_light(archive, info.representative_high);
}

SampleType read_type(Reader& reader, std::span<const ShaderInfo* const> shaders) {
  std::string shader_name;
  std::string type_name;
  uint64_t field_count = 0;
  reader.text(shader_name);
  reader.text(type_name);
  reader.value(field_count);
  const auto found = std::find_if(shaders.begin(), shaders.end(), [&](const ShaderInfo* shader) {
    return shader->name == shader_name;
  });
  if (found == shaders.end()) reader.fail("it uses the unknown shader " + printable(shader_name));
  SampleType type = make_sample_type(**found);
  type.name = type_name;
  if (field_count != type.field_count()) reader.fail("shader " + type_name + " has other fields");
  for (size_t i = 0; i < type.field_count(); ++i) {
    std::string field_name;
    reader.text(field_name);
    if (field_name != type.field(i).name) reader.fail("shader " + type_name + " has other fields");
    visit_byte(reader, type.merges[i], static_cast<uint8_t>(merge_labels.size()));
  }
  return type;
}

void write_type(Writer& writer, const SampleType& type) {
  writer.text(std::string(type.shader->name));
  writer.text(type.name);
  writer.value(static_cast<uint64_t>(type.field_count()));
  for (size_t i = 0; i < type.field_count(); ++i) {
    writer.text(std::string(type.field(i).name));
    visit_byte(writer, type.merges[i], 2);
  }
}

void check_info(const CacheInfo& info, const Reader& reader, const std::string& place) {
  if (info.width < 1 || info.height < 1 || info.width > max_image_side ||
      info.height > max_image_side) {
    reader.fail("the image size is out of range");
  }
  const Camera& camera = info.camera;
  if (!is_finite(camera.eye) || !is_finite(camera.target) || !is_finite(camera.up) ||
      !(camera.fov_y_deg > 0 && camera.fov_y_deg < 179) || camera.eye == camera.target) {
    reader.fail("the camera is not valid");
  }
  const Bounds& bounds = info.bounds;
  const bool no_bounds = bounds.low == Bounds().low && bounds.high == Bounds().high;
  if (!no_bounds && !(is_coordinate(bounds.low) && is_coordinate(bounds.high) &&
                      glm::all(glm::lessThanEqual(bounds.low, bounds.high)))) {
    reader.fail("the scene bounds are not valid");
  }
  if (info.has_members && !info.has_footprints) reader.fail("members need footprints");
  if (!is_finite(info.exposure)) reader.fail("the exposure is not finite");
  for (const float budget : {info.average_records, info.target_error}) {
    if (!(budget >= 0) || !is_finite(budget)) reader.fail("the budget is not valid");
  }
  for (size_t i = 0; i < info.lights.size(); ++i) {
    validate_light(info.lights[i], fmt::format("{}: lights/{}", place, i));
  }
  validate_light(info.representative_low, place + ": representative_lights/0");
  validate_light(info.representative_high, place + ": representative_lights/1");
}

}  // namespace

uint64_t hash_bytes(std::span<const std::byte> bytes, uint64_t seed) {
  return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

uint64_t index_hash(const CacheHeader& header, std::span<const std::byte> info,
                    std::span<const std::byte> directory) {
  const auto fields = std::as_bytes(std::span(&header, 1)).first(offsetof(CacheHeader, index_hash));
  return hash_bytes(directory, hash_bytes(info, hash_bytes(fields)));
}

std::vector<std::byte> encode_info(const CacheInfo& info) {
  Writer writer;
  visit_plain(writer, info);
  writer.value(static_cast<uint64_t>(info.types.size()));
  for (const SampleType& type : info.types) write_type(writer, type);
  writer.value(static_cast<uint64_t>(info.lights.size()));
  for (const Light& light : info.lights) visit_light(writer, light);
  return writer.bytes;
}

CacheInfo decode_info(std::span<const std::byte> bytes, std::span<const ShaderInfo* const> shaders,
                      const std::string& place) {
  Reader reader(bytes, place);
  CacheInfo info;
  visit_plain(reader, info);
  uint64_t count = 0;
  reader.value(count);
  if (count > max_sample_types) reader.fail("it has too many sample types");
  for (uint64_t i = 0; i < count; ++i) info.types.push_back(read_type(reader, shaders));
  reader.value(count);
  if (count > max_lights) reader.fail("it has too many lights");
  for (uint64_t i = 0; i < count; ++i) visit_light(reader, info.lights.emplace_back());
  if (!reader.at_end()) reader.fail("the header has bytes left over");
  check_info(info, reader, place);
  return info;
}

}  // namespace relume
