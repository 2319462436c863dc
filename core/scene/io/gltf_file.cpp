#include "core/scene/io/gltf_file.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <cstring>
#include <set>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/mapped_file.h"
#include "core/scene/io/gltf_check.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

RareEvent dropped_triangles("glTF triangles without area dropped");
RareEvent left_out_primitives("glTF primitives of lines or points left out");
RareEvent collapsed_nodes("glTF nodes that scale to nothing left out");

constexpr uint64_t max_gltf_bytes = uint64_t{2} << 30;
constexpr int max_node_depth = 256;
/// Keeps the image's own bytes: decoding is image_io's.
bool keep_image(tinygltf::Image* image, int /*index*/, std::string* /*error*/,
                std::string* /*warning*/, int /*width*/, int /*height*/, const unsigned char* bytes,
                int size, void* /*user*/) {
  image->image.assign(bytes, bytes + size);
  image->as_is = true;
  return true;
}

bool file_exists(const std::string& path, void* /*user*/) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

std::string same_path(const std::string& path, void* /*user*/) {
  return path;
}

bool read_part(std::vector<unsigned char>* bytes, std::string* error, const std::string& path,
               void* /*user*/) {
  try {
    const std::string text = read_text_file(path, max_gltf_bytes);
    bytes->assign(text.begin(), text.end());
    return true;
  } catch (const Error& failure) {
    *error = failure.what();
    return false;
  }
}

tinygltf::Model parse_model(std::span<const std::byte> bytes, const std::filesystem::path& path) {
  tinygltf::TinyGLTF parser;
  parser.SetImageLoader(keep_image, nullptr);
  parser.SetFsCallbacks({file_exists, same_path, read_part, nullptr, nullptr});
  tinygltf::Model model;
  std::string error;
  std::string warning;
  const std::string folder = path.parent_path().empty() ? "." : path.parent_path().string();
  const auto size = static_cast<unsigned int>(bytes.size());
  const bool ok =
      is_binary_gltf(bytes)
          ? parser.LoadBinaryFromMemory(&model, &error, &warning,
                                        reinterpret_cast<const unsigned char*>(bytes.data()), size,
                                        folder)
          : parser.LoadASCIIFromString(&model, &error, &warning,
                                       reinterpret_cast<const char*>(bytes.data()), size, folder);
  if (ok) return model;
  std::ranges::replace(error, '\n', ' ');
  error.erase(error.find_last_not_of(". ") + 1);
  throw input_error(path.string(), "cannot be read: " + error,
                    "check the file and those beside it");
}

/// From the library's model, in which nothing is checked, to content that is.
class Reader {
 public:
  Reader(const tinygltf::Model& model, const std::string& file) : model_(model), file_(file) {}

  GltfContent read() {
    for (const tinygltf::Image& image : model_.images) content_.images.push_back(read_image(image));
    for (const tinygltf::Material& material : model_.materials) {
      content_.materials.push_back(read_material(material));
    }
    for (const tinygltf::Mesh& mesh : model_.meshes) content_.meshes.push_back(read_mesh(mesh));
    visited_.assign(model_.nodes.size(), false);
    for (const int root : scene_roots()) read_node(root, dmat4(1), 0);
    return std::move(content_);
  }

 private:
  using dmat4 = glm::dmat4;

  [[noreturn]] void fail(const std::string& place, std::string_view what,
                         std::string_view mend = "export the file again") const {
    throw input_error(file_ + ": " + place, what, mend);
  }
  template <class T>
  const T& at(const std::vector<T>& list, int index, const std::string& place,
              std::string_view kind) const {
    if (index >= 0 && static_cast<size_t>(index) < list.size()) return list[index];
    fail(place, fmt::format("refers to {} {} of {}", kind, index, list.size()));
  }

  GltfImage read_image(const tinygltf::Image& image) const {
    const auto* bytes = reinterpret_cast<const std::byte*>(image.image.data());
    const std::string name = image.name.empty() ? image.uri : image.name;
    return {printable(name), {bytes, bytes + image.image.size()}};
  }

  /// The image of a texture reference, or -1.
  template <class TextureInfo>
  int image_of(const TextureInfo& info, const std::string& place) const {
    if (info.index < 0) return -1;
    const tinygltf::Texture& texture = at(model_.textures, info.index, place, "texture");
    if (texture.source < 0) return -1;
    at(model_.images, texture.source, place, "image");
    return texture.source;
  }

  static float clamped(double value, double low, double high) {
    return value >= low ? static_cast<float>(std::min(value, high)) : static_cast<float>(low);
  }

  GltfMaterial read_material(const tinygltf::Material& source) const {
    GltfMaterial material;
    material.name = printable(source.name);
    const std::string place = fmt::format("material \"{}\"", material.name);
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    for (size_t i = 0; i < std::min<size_t>(4, pbr.baseColorFactor.size()); ++i) {
      material.base_color[i] = clamped(pbr.baseColorFactor[i], 0, 1);
    }
    material.base_image = image_of(pbr.baseColorTexture, place);
    material.metallic = clamped(pbr.metallicFactor, 0, 1);
    material.roughness = clamped(pbr.roughnessFactor, 0, 1);
    material.metal_rough_image = image_of(pbr.metallicRoughnessTexture, place);
    material.normal_image = image_of(source.normalTexture, place);
    material.normal_scale = clamped(source.normalTexture.scale, -1000, 1000);
    material.reflectance = read_reflectance(source);
    read_emission(source, place, material);
    if (source.occlusionTexture.index >= 0) material.left_out.emplace_back("occlusion");
    drop_other_uvs(source, material);
    material.alpha = source.alphaMode == "MASK"    ? GltfAlpha::mask
                     : source.alphaMode == "BLEND" ? GltfAlpha::blend
                                                   : GltfAlpha::opaque;
    material.alpha_cutoff = clamped(source.alphaCutoff, 0, 1);
    return material;
  }

  void read_emission(const tinygltf::Material& source, const std::string& place,
                     GltfMaterial& material) const {
    const double strength =
        extension_number(source, "KHR_materials_emissive_strength", "emissiveStrength", 1);
    for (size_t i = 0; i < std::min<size_t>(3, source.emissiveFactor.size()); ++i) {
      const float factor = clamped(source.emissiveFactor[i], 0, 1);
      material.emission[i] = clamped(factor * strength, 0, max_emission);
    }
    if (max_component(material.emission) > 0) {
      material.emission_image = image_of(source.emissiveTexture, place);
    }
  }

  /// KHR_texture_transform: offset + rotation * (scale * uv).
  struct UvTransform {
    dvec2 offset{0};
    dvec2 scale{1};
    double rotation = 0;
    int set = 0;

    bool operator==(const UvTransform&) const = default;
    vec2 apply(dvec2 uv) const {
      const dvec2 s = scale * uv;
      const double c = std::cos(rotation);
      const double n = std::sin(rotation);
      const dvec2 turned(c * s.x + n * s.y, c * s.y - n * s.x);
      const dvec2 result = offset + turned;
      return {result.x, 1 - result.y};  // glTF counts v downwards
    }
  };

  static dvec2 pair_of(const tinygltf::Value& value, const char* key, dvec2 fallback) {
    if (!value.Has(key) || value.Get(key).ArrayLen() != 2) return fallback;
    const tinygltf::Value& list = value.Get(key);
    if (!list.Get(0).IsNumber() || !list.Get(1).IsNumber()) return fallback;
    return {list.Get(0).GetNumberAsDouble(), list.Get(1).GetNumberAsDouble()};
  }

  template <class TextureInfo>
  static UvTransform uv_transform(const TextureInfo& info) {
    UvTransform result;
    result.set = info.texCoord;
    const auto found = info.extensions.find("KHR_texture_transform");
    if (found == info.extensions.end() || !found->second.IsObject()) return result;
    const tinygltf::Value& value = found->second;
    result.offset = pair_of(value, "offset", result.offset);
    result.scale = pair_of(value, "scale", result.scale);
    if (value.Has("rotation") && value.Get("rotation").IsNumber()) {
      result.rotation = value.Get("rotation").GetNumberAsDouble();
    }
    if (value.Has("texCoord") && value.Get("texCoord").IsInt()) {
      result.set = value.Get("texCoord").GetNumberAsInt();
    }
    return result;
  }

  /// Of the first texture that the material has.
  static UvTransform uv_transform(const tinygltf::Material& material) {
    const tinygltf::PbrMetallicRoughness& pbr = material.pbrMetallicRoughness;
    if (pbr.baseColorTexture.index >= 0) return uv_transform(pbr.baseColorTexture);
    if (pbr.metallicRoughnessTexture.index >= 0) return uv_transform(pbr.metallicRoughnessTexture);
    if (material.normalTexture.index >= 0) return uv_transform(material.normalTexture);
    return uv_transform(material.emissiveTexture);
  }

  static double extension_number(const tinygltf::Material& source, const char* extension,
                                 const char* key, double fallback) {
    const auto found = source.extensions.find(extension);
    if (found == source.extensions.end() || !found->second.Has(key)) return fallback;
    const tinygltf::Value& value = found->second.Get(key);
    return value.IsNumber() ? value.GetNumberAsDouble() : fallback;
  }

  /// F0 of a dielectric: ((ior - 1) / (ior + 1))^2, times the factor of KHR_materials_specular.
  static float read_reflectance(const tinygltf::Material& source) {
    const double ior = extension_number(source, "KHR_materials_ior", "ior", 1.5);
    const double factor = extension_number(source, "KHR_materials_specular", "specularFactor", 1);
    const double root = (ior - 1) / (ior + 1);
    return clamped(root * root * factor, 0, 1);
  }

  /// Texture coordinates are one set a primitive, those of the first texture: images that lie by
  /// others are left out, and what they would have given alone.
  static void drop_other_uvs(const tinygltf::Material& source, GltfMaterial& material) {
    const UvTransform read = uv_transform(source);
    const auto drop = [&](const auto& info, const char* name, int& image) {
      if (image < 0 || uv_transform(info) == read) return false;
      image = -1;
      material.left_out.push_back(
          fmt::format("{}, which has other texture coordinates than the first texture", name));
      return true;
    };
    drop(source.pbrMetallicRoughness.metallicRoughnessTexture, "metallicRoughnessTexture",
         material.metal_rough_image);
    drop(source.normalTexture, "normalTexture", material.normal_image);
    if (drop(source.emissiveTexture, "emissiveTexture", material.emission_image)) {
      material.emission = vec3(0);  // or all of the surface would shine
    }
  }

  /// Elements of an accessor as doubles, `width` each, in [0, 1] or [-1, 1] where normalised.
  struct Elements {
    const unsigned char* first = nullptr;
    size_t stride = 0;
    size_t count = 0;
    int component = 0;
    bool normalized = false;

    double value(size_t element, int i) const {
      const unsigned char* const p = first + element * stride;
      switch (component) {
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
          return load<float>(p, i);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
          return scaled(load<uint8_t>(p, i), 255);
        case TINYGLTF_COMPONENT_TYPE_BYTE:
          return scaled(load<int8_t>(p, i), 127);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
          return scaled(load<uint16_t>(p, i), 65535);
        case TINYGLTF_COMPONENT_TYPE_SHORT:
          return scaled(load<int16_t>(p, i), 32767);
        default:
          return load<uint32_t>(p, i);
      }
    }
    vec3 vector(size_t element) const {
      return {value(element, 0), value(element, 1), value(element, 2)};
    }

   private:
    template <class T>
    static double load(const unsigned char* p, int i) {
      T value;
      std::memcpy(&value, p + sizeof(T) * static_cast<size_t>(i), sizeof(T));
      return value;
    }
    double scaled(double value, double most) const {
      return normalized ? std::max(value / most, -1.0) : value;
    }
  };

  /// Accessor `index`, of `width` components; every byte of it lies in its buffer.
  Elements elements(int index, int width, const std::string& place) const {
    const tinygltf::Accessor& accessor = at(model_.accessors, index, place, "accessor");
    const std::string where = fmt::format("{}: accessor {}", place, index);
    if (accessor.sparse.isSparse || accessor.bufferView < 0) {
      fail(where, "is sparse", "export it without sparse accessors");
    }
    const tinygltf::BufferView& view = at(model_.bufferViews, accessor.bufferView, where, "view");
    const tinygltf::Buffer& buffer = at(model_.buffers, view.buffer, where, "buffer");
    const int bytes =
        tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(accessor.componentType));
    const int components = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type));
    if (bytes <= 0 || bytes > 4 || components != width) fail(where, "has an unexpected type");
    const uint64_t size = static_cast<uint64_t>(bytes) * static_cast<uint64_t>(width);
    const uint64_t stride = view.byteStride == 0 ? size : view.byteStride;
    const uint64_t view_end = uint64_t{view.byteOffset} + view.byteLength;
    const bool view_fits = view.byteOffset <= buffer.data.size() && view_end >= view.byteOffset &&
                           view_end <= buffer.data.size();
    const bool count_fits = accessor.count <= buffer.data.size() && stride <= (uint64_t{1} << 20) &&
                            stride >= size && accessor.byteOffset <= view.byteLength;
    if (!view_fits || !count_fits || accessor.count == 0 ||
        accessor.byteOffset + (accessor.count - 1) * stride + size > view.byteLength) {
      fail(where, "reaches beyond its buffer", "the file is cut short or damaged: copy it again");
    }
    return {buffer.data.data() + view.byteOffset + accessor.byteOffset, stride, accessor.count,
            accessor.componentType, accessor.normalized};
  }

  static int attribute(const tinygltf::Primitive& source, const std::string& name) {
    const auto found = source.attributes.find(name);
    return found == source.attributes.end() ? -1 : found->second;
  }

  std::vector<vec3> read_vectors(int accessor, const std::string& place, bool is_position) const {
    const Elements source = elements(accessor, 3, place);
    if (source.count > 3 * max_triangles) {
      throw limit_error(file_ + ": " + place, "too many vertices", "split the mesh");
    }
    std::vector<vec3> vectors(source.count);
    for (size_t i = 0; i < source.count; ++i) {
      vectors[i] = source.vector(i);
      if (is_position ? is_coordinate(vectors[i]) : is_finite(vectors[i])) continue;
      fail(place, fmt::format("vertex {} is not finite or beyond {}", i, max_coordinate));
    }
    return vectors;
  }

  void read_uvs(const tinygltf::Primitive& source, const std::string& place,
                GltfPrimitive& primitive) const {
    const UvTransform transform =
        primitive.material < 0 ? UvTransform{} : uv_transform(model_.materials[primitive.material]);
    const int accessor = attribute(source, fmt::format("TEXCOORD_{}", transform.set));
    if (accessor < 0) return;
    const Elements uvs = elements(accessor, 2, place);
    if (uvs.count != primitive.positions.size()) fail(place, "has not as many uvs as positions");
    primitive.uvs.resize(uvs.count);
    for (size_t i = 0; i < uvs.count; ++i) {
      primitive.uvs[i] = transform.apply({uvs.value(i, 0), uvs.value(i, 1)});
      if (!is_finite(primitive.uvs[i].x) || !is_finite(primitive.uvs[i].y)) {
        fail(place, fmt::format("the uv of vertex {} is not finite", i));
      }
    }
  }

  void read_tangents(const tinygltf::Primitive& source, const std::string& place,
                     GltfPrimitive& primitive) const {
    const int accessor = attribute(source, "TANGENT");
    const bool is_mapped =
        primitive.material >= 0 && content_.materials[primitive.material].normal_image >= 0;
    if (accessor < 0 || !is_mapped) return;
    const Elements tangents = elements(accessor, 4, place);
    if (tangents.count != primitive.positions.size()) {
      fail(place, "has not as many tangents as positions");
    }
    primitive.tangents.resize(tangents.count);
    for (size_t i = 0; i < tangents.count; ++i) {
      const vec3 tangent = tangents.vector(i);
      if (!is_finite(tangent))
        fail(place, fmt::format("the tangent of vertex {} is not finite", i));
      primitive.tangents[i] = vec4(tangent, tangents.value(i, 3) < 0 ? -1 : 1);
    }
  }

  std::vector<uint32_t> read_indices(const tinygltf::Primitive& source, size_t vertices,
                                     const std::string& place) const {
    std::vector<uint32_t> indices;
    if (source.indices < 0) {
      for (size_t i = 0; i < vertices; ++i) indices.push_back(static_cast<uint32_t>(i));
      return indices;
    }
    const Elements list = elements(source.indices, 1, place);
    if (list.component == TINYGLTF_COMPONENT_TYPE_FLOAT) fail(place, "has indices of type float");
    indices.resize(list.count);
    for (size_t i = 0; i < list.count; ++i) {
      const double index = list.value(i, 0);
      if (!(index >= 0) || !(index < static_cast<double>(vertices))) {
        fail(place, fmt::format("index {} is {} of {} vertices", i, index, vertices));
      }
      indices[i] = static_cast<uint32_t>(index);
    }
    return indices;
  }

  void cut_triangles(const tinygltf::Primitive& source, std::span<const uint32_t> indices,
                     GltfPrimitive& primitive) const {
    const auto add = [&](uint32_t a, uint32_t b, uint32_t c) {
      const auto& p = primitive.positions;
      if (has_area(p[a], p[b], p[c])) {
        primitive.triangles.emplace_back(a, b, c);
      } else {
        dropped_triangles.add();
      }
    };
    if (source.mode == TINYGLTF_MODE_TRIANGLES) {
      for (size_t i = 0; i + 2 < indices.size(); i += 3) {
        add(indices[i], indices[i + 1], indices[i + 2]);
      }
      return;
    }
    for (size_t i = 0; i + 2 < indices.size(); ++i) {
      if (source.mode == TINYGLTF_MODE_TRIANGLE_FAN) {
        add(indices[0], indices[i + 1], indices[i + 2]);
      } else {
        add(indices[i], indices[i + 1 + i % 2], indices[i + 2 - i % 2]);
      }
    }
  }

  GltfMesh read_mesh(const tinygltf::Mesh& source) {
    GltfMesh mesh{printable(source.name), {}};
    const size_t index = content_.meshes.size();
    if (mesh.name.empty()) mesh.name = fmt::format("mesh-{}", index);
    for (size_t i = 0; i < source.primitives.size(); ++i) {
      const tinygltf::Primitive& part = source.primitives[i];
      const std::string place = fmt::format("/meshes/{}/primitives/{}", index, i);
      if (part.mode < TINYGLTF_MODE_TRIANGLES) {
        left_out_primitives.add();
        continue;
      }
      GltfPrimitive primitive;
      primitive.material = part.material;
      if (part.material >= 0) at(model_.materials, part.material, place, "material");
      const int positions = attribute(part, "POSITION");
      if (positions < 0) fail(place, "has no positions");
      primitive.positions = read_vectors(positions, place, true);
      if (const int normals = attribute(part, "NORMAL"); normals >= 0) {
        primitive.normals = read_vectors(normals, place, false);
        if (primitive.normals.size() != primitive.positions.size()) {
          fail(place, "has not as many normals as positions");
        }
      }
      read_uvs(part, place, primitive);
      read_tangents(part, place, primitive);
      cut_triangles(part, read_indices(part, primitive.positions.size(), place), primitive);
      triangles_ += primitive.triangles.size();
      if (triangles_ > max_triangles) {
        throw limit_error(file_, "too many triangles",
                          fmt::format("the limit is {}", max_triangles));
      }
      if (!primitive.triangles.empty()) mesh.primitives.push_back(std::move(primitive));
    }
    return mesh;
  }

  /// Nodes that the default scene starts from; without scenes, those that are nobody's children.
  std::vector<int> scene_roots() const {
    if (!model_.scenes.empty()) {
      return at(model_.scenes, std::max(0, model_.defaultScene), "/scene", "scene").nodes;
    }
    std::vector<bool> is_child(model_.nodes.size(), false);
    for (const tinygltf::Node& node : model_.nodes) {
      for (const int child : node.children) {
        if (child >= 0 && static_cast<size_t>(child) < is_child.size()) is_child[child] = true;
      }
    }
    std::vector<int> roots;
    for (size_t i = 0; i < is_child.size(); ++i) {
      if (!is_child[i]) roots.push_back(static_cast<int>(i));
    }
    return roots;
  }

  dmat4 local_matrix(const tinygltf::Node& node, const std::string& place) const {
    dmat4 m(1);
    if (node.matrix.size() == 16) {
      for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = node.matrix[i];
    } else {
      if (node.rotation.size() == 4) {
        const auto& q = node.rotation;
        const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        if (norm > 0) m = rotation(q[0] / norm, q[1] / norm, q[2] / norm, q[3] / norm);
      }
      for (size_t i = 0; i < 3 && node.scale.size() == 3; ++i) m[i] *= node.scale[i];
      for (size_t i = 0; i < 3 && node.translation.size() == 3; ++i) m[3][i] = node.translation[i];
    }
    for (int i = 0; i < 16; ++i) {
      const double value = m[i / 4][i % 4];
      if (!(std::abs(value) <= max_coordinate)) fail(place, "its transform is not finite");
    }
    return m;
  }

  static dmat4 rotation(double x, double y, double z, double w) {
    dmat4 m(1);
    m[0] = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0};
    m[1] = {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0};
    m[2] = {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0};
    return m;
  }

  void read_node(int index, const dmat4& parent, int depth) {
    const std::string place = fmt::format("/nodes/{}", index);
    const tinygltf::Node& node = at(model_.nodes, index, place, "node");
    if (visited_[index]) fail(place, "has two parents or is its own");
    visited_[index] = true;
    if (depth > max_node_depth) {
      throw limit_error(file_ + ": " + place, "lies too deep",
                        fmt::format("the limit is {} nodes above each other", max_node_depth));
    }
    const dmat4 world = parent * local_matrix(node, place);
    const auto light = node.extensions.find("KHR_lights_punctual");
    const bool has_light = light != node.extensions.end() && light->second.Has("light") &&
                           light->second.Get("light").IsInt();
    const bool shows_something = node.mesh >= 0 || node.camera >= 0 || has_light;
    if (shows_something && !is_coordinate(vec3(world[3]))) fail(place, "lies too far away");
    if (node.mesh >= 0) place_mesh(node.mesh, world, place);
    if (node.camera >= 0) read_camera(node.camera, world, place);
    if (has_light) {
      read_light(light->second.Get("light").GetNumberAsInt(), node, world, place);
    }
    for (const int child : node.children) read_node(child, world, depth + 1);
  }

  void place_mesh(int mesh, const dmat4& world, const std::string& place) {
    at(model_.meshes, mesh, place, "mesh");
    if (content_.meshes[mesh].primitives.empty()) return;
    const GltfPlacement placement{mesh, mat4x3(glm::dmat4x3(world))};
    if (!(uniform_scale(placement.world_from_local) > 1e-12f)) {
      collapsed_nodes.add();
      return;
    }
    if (content_.placements.size() >= max_instances) {
      throw limit_error(file_, "too many instances", fmt::format("the limit is {}", max_instances));
    }
    content_.placements.push_back(placement);
  }

  void read_camera(int index, const dmat4& world, const std::string& place) {
    const tinygltf::Camera& source = at(model_.cameras, index, place, "camera");
    const double fov = source.perspective.yfov;
    if (source.type != "perspective" || !(fov > 0 && fov < 3.1)) return;
    const vec3 back = normalize_or(vec3(world[2]), vec3(0));
    const vec3 up = normalize_or(vec3(world[1]), vec3(0));
    if (!(glm::length(glm::cross(back, up)) > 1e-5f)) {  // scaled to nothing in one of them
      collapsed_nodes.add();
      return;
    }
    GltfCamera camera;
    camera.camera.eye = vec3(world[3]);
    camera.camera.target = target_ahead(camera.camera.eye, -back);
    camera.camera.up = up;
    camera.camera.fov_y_deg = static_cast<float>(fov * 180 / 3.14159265358979323846);
    camera.aspect = clamped(source.perspective.aspectRatio, 0, 100);
    content_.cameras.push_back(camera);
  }

  void read_light(int index, const tinygltf::Node& node, const dmat4& world,
                  const std::string& place) {
    const tinygltf::Light& source = at(model_.lights, index, place, "light");
    Light light;
    light.type = source.type == "directional" ? LightType::directional
                 : source.type == "spot"      ? LightType::spot
                                              : LightType::point;
    light.position = vec3(world[3]);
    light.direction = normalize_or(vec3(-world[2]), vec3(0, -1, 0));
    for (size_t c = 0; c < 3 && source.color.size() == 3; ++c) {
      light.color[c] = clamped(source.color[c], 0, 1e20);
    }
    light.gain = clamped(source.intensity, 0, 1e20);
    light.range = source.range > 0 ? clamped(source.range, 1e-15, 1e15) : 0.0f;
    const double degrees = 180 / 3.14159265358979323846;
    light.outer_angle_deg = clamped(source.spot.outerConeAngle * degrees, min_spot_angle_deg, 90);
    light.inner_angle_deg = clamped(source.spot.innerConeAngle * degrees, 0, light.outer_angle_deg);
    std::string name = printable(source.name.empty() ? node.name : source.name);
    std::ranges::replace(name, '.', '-');
    if (name.empty()) name = "light";
    light.name = name;
    for (int i = 2; !light_names_.insert(light.name).second; ++i) {
      light.name = fmt::format("{}-{}", name, i);
    }
    if (content_.lights.size() >= max_lights) {
      throw limit_error(file_, "too many lights", fmt::format("the limit is {}", max_lights));
    }
    validate_light(light, file_ + ": " + place);
    content_.lights.push_back(light);
  }

  const tinygltf::Model& model_;
  const std::string& file_;
  GltfContent content_;
  std::vector<bool> visited_;
  std::set<std::string> light_names_;
  uint64_t triangles_ = 0;
};

}  // namespace

GltfContent read_gltf(const std::filesystem::path& path) {
  const std::string file = path.string();
  const MappedFile mapped(path);
  if (mapped.bytes().size() > max_gltf_bytes) {
    throw limit_error(file, "is too large", "the limit is 2 GiB");
  }
  check_gltf(mapped.bytes(), file);
  const tinygltf::Model model = parse_model(mapped.bytes(), path);
  return Reader(model, file).read();
}

}  // namespace relume
