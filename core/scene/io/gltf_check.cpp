#include "core/scene/io/gltf_check.h"

#include <fmt/format.h>

#include <array>
#include <cstring>

#include "core/base/error.h"
#include "core/scene/io/json_node.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

constexpr uint64_t max_parts = 1'000'000;  ///< of each kind: nodes, meshes, accessors, ...
constexpr std::string_view binary_magic = "glTF";
constexpr uint32_t json_chunk = 0x4E4F534A;
constexpr std::array known_extensions = {
    std::string_view("KHR_lights_punctual"),   std::string_view("KHR_materials_emissive_strength"),
    std::string_view("KHR_materials_ior"),     std::string_view("KHR_materials_specular"),
    std::string_view("KHR_texture_transform"), std::string_view("KHR_mesh_quantization")};

uint32_t read_word(std::span<const std::byte> bytes, size_t at) {
  uint32_t word = 0;
  std::memcpy(&word, &bytes[at], sizeof(word));
  return word;
}

/// The JSON of either container; sizes are checked.
std::string_view json_text(std::span<const std::byte> bytes, const std::string& file) {
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  if (!is_binary_gltf(bytes)) return {text, bytes.size()};
  if (bytes.size() < 20 || read_word(bytes, 4) != 2 || read_word(bytes, 16) != json_chunk) {
    throw input_error(file, "is not a version 2 GLB that starts with JSON", "export it again");
  }
  const std::string mend = "the file is cut short or damaged: copy it again";
  if (const uint32_t said = read_word(bytes, 8); said != bytes.size()) {
    throw input_error(file, fmt::format("says it has {} bytes, and has {}", said, bytes.size()),
                      mend);
  }
  const uint64_t length = read_word(bytes, 12);
  if (length > bytes.size() - 20) {
    throw input_error(
        file, fmt::format("says its JSON has {} bytes, and has {} in all", length, bytes.size()),
        mend);
  }
  return {text + 20, length};
}

}  // namespace

bool is_binary_gltf(std::span<const std::byte> bytes) {
  return bytes.size() >= 4 && std::memcmp(bytes.data(), binary_magic.data(), 4) == 0;
}

void check_gltf(std::span<const std::byte> bytes, const std::string& file) {
  const JsonDocument document(std::string(json_text(bytes, file)), file);
  const JsonNode root = document.root();
  if (!root.is_object()) throw root.error("is no glTF", "give a glTF 2.0 file");
  const JsonNode asset = root.get("asset", "give a glTF 2.0 file");
  const std::string version = asset.get("version", "say \"2.0\"").text(max_name_length);
  if (!version.starts_with("2.")) {
    throw asset.error("has version " + version, "only glTF 2 is read: export it again");
  }
  if (const auto required = root.find("extensionsRequired")) {
    for (const JsonNode& item : required->items(max_parts)) {
      const std::string name = item.text(max_name_length);
      if (std::ranges::find(known_extensions, name) != known_extensions.end()) continue;
      throw item.error("the file needs the extension " + name + ", which is not supported",
                       "export it without that extension");
    }
  }
  for (const char* key : {"accessors", "bufferViews", "buffers", "images", "materials", "meshes",
                          "nodes", "scenes", "textures", "cameras"}) {
    if (const auto list = root.find(key)) list->items(max_parts);
  }
}

}  // namespace relume
