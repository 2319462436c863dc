#include "core/scene/io/obj.h"

#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include <istream>
#include <sstream>
#include <streambuf>
#include <unordered_map>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/mapped_file.h"
#include "core/scene/io/obj_parts.h"

namespace relume {
namespace {

using Real = tinyobj::real_t;

constexpr uint64_t max_mtl_bytes = uint64_t{64} << 20;

/// Reads a text that stays where it is.
class TextBuffer : public std::streambuf {
 public:
  explicit TextBuffer(std::string_view text) {
    char* begin = const_cast<char*>(text.data());  // never written through: there is no put area
    setg(begin, begin, begin + text.size());
  }
};

std::string without_blanks_around(const std::string& text) {
  const size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

/// Receives the parser's callbacks.
struct Collector {
  ObjContent content;
  uint32_t material = 0;
  std::unordered_map<std::string, uint32_t> material_ids{{"", 0}};

  static Collector& from(void* user) { return *static_cast<Collector*>(user); }

  /// OBJ counts from 1, or from the end with negative numbers; 0 is "not given".
  static int32_t resolve(int index, size_t count) {
    if (index == 0) return -1;
    const int64_t resolved = index > 0 ? int64_t{index} - 1 : static_cast<int64_t>(count) + index;
    CHECK_MSG(resolved >= 0 && resolved <= INT32_MAX, "index {} of {}", index, count);
    return static_cast<int32_t>(resolved);
  }

  static void on_vertex(void* user, Real x, Real y, Real z, Real /*w*/) {
    from(user).content.positions.emplace_back(x, y, z);
  }
  static void on_normal(void* user, Real x, Real y, Real z) {
    from(user).content.normals.emplace_back(x, y, z);
  }
  static void on_uv(void* user, Real u, Real v, Real /*w*/) {
    from(user).content.uvs.emplace_back(u, v);
  }

  static void on_face(void* user, tinyobj::index_t* indices, int count) {
    Collector& self = from(user);
    ObjContent& content = self.content;
    for (int i = 0; i < count; ++i) {
      if (indices[i].vertex_index == 0) break;  // a comment behind the face
      content.corners.push_back({resolve(indices[i].vertex_index, content.positions.size()),
                                 resolve(indices[i].texcoord_index, content.uvs.size()),
                                 resolve(indices[i].normal_index, content.normals.size())});
    }
    content.face_offsets.push_back(content.corners.size());
    content.face_materials.push_back(self.material);
  }

  static void on_material(void* user, const char* name, int /*id*/) {
    Collector& self = from(user);
    const std::string key = without_blanks_around(name);
    const auto next = static_cast<uint32_t>(self.content.material_names.size());
    const auto [found, added] = self.material_ids.try_emplace(key, next);
    if (added) self.content.material_names.push_back(key);
    self.material = found->second;
  }
};

ObjContent parse_obj(std::string_view text, const ObjSummary& summary, const std::string& file) {
  TextBuffer buffer(text);
  std::istream stream(&buffer);
  Collector collector;
  collector.content.positions.reserve(summary.positions);
  collector.content.uvs.reserve(summary.uvs);
  collector.content.normals.reserve(summary.normals);
  collector.content.corners.reserve(summary.corners);
  collector.content.face_offsets.reserve(summary.faces + 1);
  collector.content.face_materials.reserve(summary.faces);
  tinyobj::callback_t callbacks;
  callbacks.vertex_cb = Collector::on_vertex;
  callbacks.normal_cb = Collector::on_normal;
  callbacks.texcoord_cb = Collector::on_uv;
  callbacks.index_cb = Collector::on_face;
  callbacks.usemtl_cb = Collector::on_material;
  std::string warning;
  std::string error;
  if (!tinyobj::LoadObjWithCallback(stream, callbacks, &collector, nullptr, &warning, &error)) {
    throw input_error(file, "cannot be parsed: " + error, "check the file");
  }
  const ObjContent& content = collector.content;
  // The strict pass and the parser must agree, or its guarantees do not hold for this data.
  if (content.positions.size() != summary.positions || content.uvs.size() != summary.uvs ||
      content.normals.size() != summary.normals || content.corners.size() != summary.corners ||
      content.face_materials.size() != summary.faces) {
    throw input_error(file, "its lines read differently the second time",
                      "check for odd characters");
  }
  return std::move(collector.content);
}

void append_mtl(const std::filesystem::path& path, MtlTable& table) {
  const std::string file = path.string();
  const std::string text = read_text_file(path, max_mtl_bytes);
  check_mtl_text(text, file);
  std::istringstream stream(text);
  std::map<std::string, int> indices;
  std::vector<tinyobj::material_t> materials;
  std::string warning;
  std::string error;
  tinyobj::LoadMtl(&indices, &materials, &stream, &warning, &error);
  for (const tinyobj::material_t& material : materials) {
    MtlMaterial own;
    own.file = file;
    own.diffuse = vec3(material.diffuse[0], material.diffuse[1], material.diffuse[2]);
    own.specular = vec3(material.specular[0], material.specular[1], material.specular[2]);
    own.emission = vec3(material.emission[0], material.emission[1], material.emission[2]);
    own.exponent = static_cast<float>(material.shininess);
    own.opacity = static_cast<float>(material.dissolve);
    own.diffuse_texture = without_blanks_around(material.diffuse_texname);
    own.alpha_texture = without_blanks_around(material.alpha_texname);
    own.emission_texture = without_blanks_around(material.emissive_texname);
    const std::string name = without_blanks_around(material.name);
    if (!name.empty()) table.try_emplace(name, std::move(own));
  }
}

/// The files of one mtllib statement: all of it as one name with spaces, else word by word.
std::vector<std::filesystem::path> mtl_paths(const std::filesystem::path& folder,
                                             std::string names) {
  std::replace(names.begin(), names.end(), '\\', '/');
  std::error_code ignored;
  if (std::filesystem::exists(folder / names, ignored)) return {folder / names};
  std::vector<std::filesystem::path> paths;
  std::istringstream words(names);
  for (std::string word; words >> word;) {
    if (std::filesystem::exists(folder / word, ignored)) paths.push_back(folder / word);
  }
  return paths;
}

MtlTable load_mtls(const ObjSummary& summary, const std::filesystem::path& obj_file) {
  MtlTable table;
  for (const std::string& names : summary.material_files) {
    const auto paths = mtl_paths(obj_file.parent_path(), names);
    if (paths.empty()) {
      print_import_note(obj_file.string(),
                        fmt::format("material file \"{}\" is missing; grey is used", names));
    }
    for (const std::filesystem::path& path : paths) append_mtl(path, table);
  }
  return table;
}

}  // namespace

Mesh load_obj(const std::filesystem::path& path, const ObjOptions& options, Scene& scene) {
  const std::string file = path.string();
  const MappedFile mapped(path);
  const std::string_view text(reinterpret_cast<const char*>(mapped.bytes().data()),
                              mapped.bytes().size());
  const ObjSummary summary = check_obj_text(text, file);
  const ObjContent content = parse_obj(text, summary, file);
  std::vector<uint32_t> materials;
  if (options.material_override >= 0) {
    materials.assign(content.material_names.size(),
                     static_cast<uint32_t>(options.material_override));
  } else {
    materials = add_obj_materials(content, load_mtls(summary, path), path, options, scene);
  }
  return build_obj_mesh(content, materials, options.smooth_angle_deg, file);
}

}  // namespace relume
