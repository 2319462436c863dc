#include "viewer/frames/frame_header.h"

#include <fmt/format.h>

#include <charconv>
#include <map>

#include "core/base/error.h"
#include "core/image/image_io.h"
#include "core/scene/io/load_scene.h"
#include "viewer/commands/version.h"

namespace relume {
namespace {

/// The attributes of one file by name.
class AttributeReader {
 public:
  AttributeReader(const std::filesystem::path& path, const ImageHeader& header)
      : place_(path.string()), values_(header.metadata.begin(), header.metadata.end()) {}

  const std::string& place() const { return place_; }

  std::string text(const std::string& name, bool is_required = true) const {
    const auto found = values_.find("relume:" + name);
    if (found != values_.end()) return found->second;
    if (is_required) throw broken(name, "is missing");
    return "";
  }

  template <class Number>
  Number number(const std::string& name, Number low, Number high) const {
    const std::string value = text(name);
    Number result{};
    const auto end = std::from_chars(value.data(), value.data() + value.size(), result);
    const bool is_number = end.ec == std::errc() && end.ptr == value.data() + value.size();
    if (!is_number || !(result >= low) || !(result <= high)) {
      throw broken(name, fmt::format("'{}' is not a number from {} to {}", value, low, high));
    }
    return result;
  }

  template <class E, size_t N>
  E label(const std::string& name, const std::array<Label<E>, N>& labels) const {
    return label(name, text(name), labels);
  }

  template <class E, size_t N>
  E label(const std::string& name, std::string_view value,
          const std::array<Label<E>, N>& labels) const {
    const std::optional<E> found = value_of(labels, value);
    if (!found) throw broken(name, fmt::format("'{}' is unknown", value));
    return *found;
  }

 private:
  Error broken(const std::string& name, const std::string& what) const {
    return input_error(place_, fmt::format("the attribute relume:{}: {}", name, what),
                       "render the frame again");
  }

  std::string place_;
  std::map<std::string, std::string> values_;
};

void check_version(const AttributeReader& attributes) {
  const std::string version = attributes.text("version", false);
  if (version.empty()) {
    throw input_error(attributes.place(), "no frame of relume render",
                      "give an EXR file that relume rendered");
  }
  const std::string commit = attributes.text("commit", false);
  if (version == relume_version && commit == relume_commit) return;
  throw input_error(attributes.place(),
                    fmt::format("rendered by relume {} ({}), this is {} ({})", version, commit,
                                relume_version, relume_commit),
                    "verify it with that version");
}

std::vector<FrameAov> read_aovs(const AttributeReader& attributes) {
  std::vector<FrameAov> aovs;
  std::string_view rest;
  const std::string text = attributes.text("aovs", false);
  for (rest = text; !rest.empty();) {
    const size_t comma = std::min(rest.find(','), rest.size());
    aovs.push_back(attributes.label("aovs", rest.substr(0, comma), frame_aov_labels));
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return aovs;
}

PrepareOptions read_prepare(const AttributeReader& attributes, const FrameHeader& header) {
  PrepareOptions prepare;
  prepare.method = attributes.label("method", reduction_method_labels);
  prepare.records = attributes.number("records", 1, 1024);
  prepare.budget.average_records = attributes.number("average_records", 0.0f, 64.0f);
  prepare.budget.target_error = attributes.number("target_error", 0.0f, 1.0f);
  prepare.spp = attributes.number("spp", 1, 1024);
  if (attributes.number("members", 0, 1) == 1) prepare.members = max_members;
  // A target error chooses the format by itself.
  const CacheFormat format = attributes.label("format", cache_format_labels);
  if (!(prepare.budget.target_error > 0)) prepare.format = format;
  const bool is_reduced =
      prepare.method != ReductionMethod::all && prepare.method != ReductionMethod::pure;
  prepare.predict_error = is_reduced && std::count(header.channels.begin(), header.channels.end(),
                                                   "predicted_error.V") > 0;
  prepare.width = header.width;
  prepare.height = header.height;
  return prepare;
}

}  // namespace

FrameHeader read_frame_header(const std::filesystem::path& path) {
  const ImageHeader image = read_image_header(path);
  const AttributeReader attributes(path, image);
  check_version(attributes);
  FrameHeader header;
  header.channels = image.channels;
  header.width = image.width;
  header.height = image.height;
  header.scene_file = attributes.text("scene_file");
  header.cache_hash = attributes.text("cache_hash");
  header.geometry_hash = attributes.text("geometry_hash", false);
  header.prepare = read_prepare(attributes, header);
  header.seed = attributes.number<uint64_t>("seed", 0, std::numeric_limits<uint64_t>::max());
  header.shadow = attributes.label("shadow", shadow_method_labels);
  header.instruction_set = attributes.label("isa", instruction_set_labels);
  header.aovs = read_aovs(attributes);
  header.lights = parse_lights(attributes.text("lights"), path.string() + ": relume:lights");
  return header;
}

}  // namespace relume
