#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>

#include "core/base/check.h"
#include "core/image/image_io.h"
#include "core/scene/io/gltf.h"
#include "core/scene/io/gltf_file.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace relume {
namespace {

using test::read_all;
using test::TemporaryFolder;
using test::write_all;

/// A quad: four positions, normals along z, uvs, and six 16-bit indices; 140 bytes.
std::string quad_bytes() {
  std::string bytes;
  const auto append = [&bytes](auto value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  const float corners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (const auto& c : corners) {
    for (const float x : {c[0], c[1], 0.0f}) append(x);
  }
  for (int i = 0; i < 4; ++i) {
    for (const float x : {0.0f, 0.0f, 2.0f}) append(x);
  }
  for (const auto& c : corners) {
    for (const float x : {c[0], c[1]}) append(x);
  }
  for (const int i : {0, 1, 2, 0, 2, 3}) append(static_cast<uint16_t>(i));
  return bytes;
}

/// The parts of a glTF of one quad, any of which a test may replace.
struct Parts {
  std::string asset = R"({"version": "2.0"})";
  std::string buffer = R"("uri": "quad.bin", "byteLength": 140)";
  std::string views =
      R"({"buffer": 0, "byteOffset": 0, "byteLength": 48},
         {"buffer": 0, "byteOffset": 48, "byteLength": 48},
         {"buffer": 0, "byteOffset": 96, "byteLength": 32},
         {"buffer": 0, "byteOffset": 128, "byteLength": 12})";
  std::string accessors =
      R"({"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
         {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
         {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"},
         {"bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR"})";
  std::string attributes = R"("POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2)";
  std::string primitive = R"("indices": 3)";
  std::string nodes = R"({"mesh": 0})";
  std::string roots = "0";
  std::string more;  ///< further members of the root, with a leading comma

  std::string text() const {
    return "{\"asset\": " + asset + ", \"scene\": 0, \"scenes\": [{\"nodes\": [" + roots +
           "]}], \"nodes\": [" + nodes +
           "], \"meshes\": [{\"name\": \"quad\", \"primitives\": [{\"attributes\": {" + attributes +
           "}, " + primitive + "}]}], \"accessors\": [" + accessors + "], \"bufferViews\": [" +
           views + "], \"buffers\": [{" + buffer + "}]" + more + "}";
  }
};

/// A GLB of `text` and `binary`.
std::string make_glb(std::string text, std::string binary) {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  std::string glb = "glTF";
  const auto append = [&glb](uint32_t value) {
    glb.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  append(2);
  append(static_cast<uint32_t>(12 + 8 + text.size() + 8 + binary.size()));
  append(static_cast<uint32_t>(text.size()));
  append(0x4E4F534A);
  glb += text;
  append(static_cast<uint32_t>(binary.size()));
  append(0x004E4942);
  return glb + binary;
}

class GltfFile : public testing::Test {
 protected:
  GltfFile() {
    scene_.shaders.assign(shader_table().begin(), shader_table().end());
    write_all(folder_.file("quad.bin"), quad_bytes());
  }

  GltfContent read(const Parts& parts) {
    write_all(folder_.file("a b.gltf"), parts.text());
    return read_gltf(folder_.file("a b.gltf"));
  }
  std::vector<Instance> load(const Parts& parts) {
    write_all(folder_.file("a b.gltf"), parts.text());
    return load_gltf(folder_.file("a b.gltf"), options_, scene_);
  }
  void expect_error(const Parts& parts, const std::string& part) {
    SCOPED_TRACE(parts.text());
    EXPECT_ERROR(load(parts), ErrorKind::input, part);
  }
  const Mesh& mesh(size_t prototype = 0, size_t shape = 0) const {
    return std::get<Mesh>(scene_.prototypes[prototype].shapes[shape]);
  }
  const MaterialParameter& parameter(const std::string& name, size_t material = 0) const {
    for (const MaterialParameter& p : scene_.materials.at(material).parameters) {
      if (p.name == name) return p;
    }
    throw std::out_of_range(name);
  }

  TemporaryFolder folder_;
  Scene scene_;
  MaterialOptions options_;
};

TEST_F(GltfFile, AQuadComesAsItStands) {
  const std::vector<Instance> instances = load({});
  ASSERT_EQ(instances.size(), 1u);
  EXPECT_EQ(instances[0].world_from_local, identity_transform());
  ASSERT_EQ(mesh().triangles.size(), 2u);
  EXPECT_EQ(mesh().triangles[1], uvec3(0, 2, 3));
  EXPECT_EQ(mesh().positions[2], vec3(1, 1, 0));
  EXPECT_EQ(mesh().normals[0], vec3(0, 0, 1));
  EXPECT_EQ(mesh().uvs[1], vec2(1, 1)) << "v counts upwards";
  EXPECT_EQ(mesh().uvs[2], vec2(1, 0));
  EXPECT_EQ(scene_.prototypes[0].name, "quad");
}

TEST_F(GltfFile, BinaryAndEmbeddedContainersSayTheSame) {
  Parts parts;
  parts.buffer = R"("byteLength": 140)";
  write_all(folder_.file("a.glb"), make_glb(parts.text(), quad_bytes()));
  const GltfContent binary = read_gltf(folder_.file("a.glb"));
  parts.buffer =
      R"("byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAA")";
  parts.views = R"({"buffer": 0, "byteLength": 36})";
  parts.accessors = R"({"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"})";
  parts.attributes = R"("POSITION": 0)";
  parts.primitive = R"("mode": 4)";
  const GltfContent embedded = read(parts);
  ASSERT_EQ(binary.meshes[0].primitives[0].positions.size(), 4u);
  ASSERT_EQ(embedded.meshes[0].primitives[0].positions.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(embedded.meshes[0].primitives[0].positions[i],
              binary.meshes[0].primitives[0].positions[i]);
  }
}

TEST_F(GltfFile, NodesTransformTheirChildren) {
  Parts parts;
  parts.roots = "1";
  // Half a turn about z, then scaled by 2 and moved: (1, 0, 0) -> (-2, 0, 0) -> (8, 5, 0).
  parts.nodes = R"({"mesh": 0, "rotation": [0, 0, 1, 0]},
                   {"children": [0, 2], "scale": [2, 2, 2], "translation": [10, 5, 0]},
                   {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1]})";
  const std::vector<Instance> instances = load(parts);
  ASSERT_EQ(instances.size(), 2u);
  EXPECT_EQ(scene_.prototypes.size(), 1u) << "a mesh is stored once";
  const vec3 turned = transform_point(instances[0].world_from_local, {1, 0, 0});
  EXPECT_LT(glm::distance(turned, vec3(8, 5, 0)), 1e-5f);
  const vec3 moved = transform_point(instances[1].world_from_local, {1, 0, 0});
  EXPECT_LT(glm::distance(moved, vec3(18, 5, 0)), 1e-5f);
}

TEST_F(GltfFile, StripsFansAndMissingNormals) {
  Parts parts;
  parts.attributes = R"("POSITION": 0)";
  parts.primitive = R"("mode": 6)";
  load(parts);
  ASSERT_EQ(mesh().triangles.size(), 2u);
  for (const vec3 normal : mesh().normals) EXPECT_EQ(normal, vec3(0, 0, 1));
  parts.primitive = R"("mode": 5)";
  load(parts);
  EXPECT_EQ(mesh(1).triangles.size(), 2u);
  parts.primitive = R"("mode": 1)";
  expect_error(parts, "shows no triangle");
}

TEST_F(GltfFile, NormalisedIntegersAreScaled) {
  std::string bytes = quad_bytes();
  const uint8_t uvs[8] = {0, 0, 255, 0, 255, 255, 0, 51};
  std::memcpy(&bytes[96], uvs, sizeof(uvs));
  write_all(folder_.file("quad.bin"), bytes);
  Parts parts;
  const std::string from =
      R"({"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"})";
  parts.accessors.replace(
      parts.accessors.find(from), from.size(),
      R"({"bufferView": 2, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC2"})");
  load(parts);
  EXPECT_EQ(mesh().uvs[1], vec2(1, 1));
  EXPECT_NEAR(mesh().uvs[3].y, 0.8f, 1e-6f);
}

TEST_F(GltfFile, TextureTransformsMoveTheUvs) {
  Parts parts;
  parts.primitive = R"("indices": 3, "material": 0)";
  parts.more =
      R"(, "extensionsRequired": ["KHR_texture_transform"], "materials": [{"pbrMetallicRoughness":
         {"baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform":
         {"offset": [0.5, 0], "scale": [2, 4]}}}}}], "textures": [{}])";
  load(parts);
  EXPECT_EQ(mesh().uvs[2], vec2(2.5f, -3));
}

TEST_F(GltfFile, MetallicRoughnessBecomesGgx) {
  Parts parts;
  parts.primitive = R"("indices": 3, "material": 0)";
  parts.more =
      R"(, "materials": [{"name": "plastic", "extensions": {"KHR_materials_ior": {"ior": 2}},
      "pbrMetallicRoughness":
      {"baseColorFactor": [0.5, 0.25, 1, 1], "metallicFactor": 0, "roughnessFactor": 0.5}}])";
  load(parts);
  EXPECT_EQ(scene_.shaders[scene_.materials[0].shader]->name, "ggx");
  EXPECT_EQ(parameter("base_color").value, vec3(0.5f, 0.25f, 1));
  EXPECT_EQ(parameter("metallic").value.x, 0);
  EXPECT_EQ(parameter("roughness").value.x, 0.5f);
  EXPECT_NEAR(parameter("reflectance").value.x, 1 / 9.0f, 1e-6f);
  parts.more = R"(, "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0, 1]}}])";
  load(parts);
  EXPECT_EQ(parameter("metallic", 1).value.x, 1) << "metallic and rough unless told otherwise";
  EXPECT_EQ(parameter("roughness", 1).value.x, 1);
  EXPECT_EQ(parameter("reflectance", 1).value.x, 0.04f);
  options_.leaf_materials = {"plastic"};
  expect_error(parts, "leaf material \"plastic\" is not in it");
}

TEST_F(GltfFile, TexturesOfSurfaceAndNormalsComeWithTheirChannelsAndTangents) {
  write_png(folder_.file("map.png"), {2, 2, 4, std::vector<uint8_t>(16, 200)});
  std::string bytes = quad_bytes();
  for (int i = 0; i < 4; ++i) {
    for (const float x : {0.0f, 1.0f, 0.0f, -1.0f}) {
      bytes.append(reinterpret_cast<const char*>(&x), sizeof(x));
    }
  }
  write_all(folder_.file("quad.bin"), bytes);
  Parts parts;
  parts.buffer = R"("uri": "quad.bin", "byteLength": 204)";
  parts.views += R"(, {"buffer": 0, "byteOffset": 140, "byteLength": 64})";
  parts.accessors += R"(, {"bufferView": 4, "componentType": 5126, "count": 4, "type": "VEC4"})";
  parts.attributes += R"(, "TANGENT": 4)";
  parts.primitive = R"("indices": 3, "material": 0)";
  const auto materials = [](const std::string& more) {
    return R"(, "images": [{"uri": "map.png"}], "textures": [{"source": 0}], "materials": [{
        "pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}})" +
           more + "}]";
  };
  parts.more = materials(R"(, "normalTexture": {"index": 0, "scale": 0.5})");
  load(parts);
  EXPECT_EQ(parameter("metallic").texture, 0);
  EXPECT_EQ(parameter("metallic").channel, 2);
  EXPECT_EQ(parameter("roughness").channel, 1);
  EXPECT_FALSE(scene_.textures[0].srgb);
  EXPECT_EQ(scene_.materials[0].normal_texture, 0);
  EXPECT_EQ(scene_.materials[0].normal_scale, 0.5f);
  ASSERT_EQ(mesh().tangents.size(), 4u);
  EXPECT_EQ(mesh().tangents[3], vec4(0, 1, 0, -1));
  parts.more = materials("");
  load(parts);
  EXPECT_TRUE(mesh(1).tangents.empty()) << "nothing asks for them";
}

TEST_F(GltfFile, TellsWhatOfMaterialsIsLeftOut) {
  write_png(folder_.file("map.png"), {2, 2, 4, std::vector<uint8_t>(16, 200)});
  Parts parts;
  parts.primitive = R"("indices": 3, "material": 0)";
  parts.more = R"(, "images": [{"uri": "map.png"}], "textures": [{"source": 0}], "materials": [{
      "occlusionTexture": {"index": 0}, "pbrMetallicRoughness": {"baseColorTexture": {"index": 0},
      "metallicRoughnessTexture": {"index": 0, "texCoord": 1}}, "emissiveFactor": [1, 1, 1],
      "normalTexture": {"index": 0}, "emissiveTexture": {"index": 0, "texCoord": 1}}])";
  testing::internal::CaptureStderr();
  load(parts);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            (folder_.file("a b.gltf").string() +
             ": its materials are read without emissiveTexture, which has other texture "
             "coordinates than the first texture, metallicRoughnessTexture, which has other "
             "texture coordinates than the first texture, occlusion\n"));
  EXPECT_EQ(parameter("metallic").texture, -1);
  EXPECT_EQ(scene_.materials[0].emission_texture, -1);
  EXPECT_EQ(scene_.materials[0].emission, vec3(0)) << "not all of the surface";
  EXPECT_GE(scene_.materials[0].normal_texture, 0);
}

TEST_F(GltfFile, TheSecondSetOfTextureCoordinatesIsReadWhereTheFirstTextureAsksForIt) {
  write_png(folder_.file("map.png"), {2, 2, 4, std::vector<uint8_t>(16, 200)});
  Parts parts;
  parts.attributes = R"("POSITION": 0, "NORMAL": 1, "TEXCOORD_1": 2)";
  parts.primitive = R"("indices": 3, "material": 0)";
  parts.more = R"(, "images": [{"uri": "map.png"}], "textures": [{"source": 0}], "materials": [{
      "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 1}}}])";
  load(parts);
  EXPECT_EQ(mesh().uvs.size(), 4u);
}

TEST_F(GltfFile, ReadsEmissionWithItsStrengthAndTexture) {
  write_png(folder_.file("glow.png"), DisplayImage{1, 1, 4, {255, 128, 0, 255}});
  Parts parts;
  parts.primitive = R"("indices": 3, "material": 0)";
  const auto material = [](const std::string& more) {
    return R"(, "extensionsRequired": ["KHR_materials_emissive_strength"],
      "extensionsUsed": ["KHR_materials_emissive_strength"],
      "images": [{"uri": "glow.png"}], "textures": [{"source": 0}], "materials": [{
      "emissiveTexture": {"index": 0}, )" +
           more + "}]";
  };
  parts.more = material(R"("emissiveFactor": [1, 0.5, 0.25],
      "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}})");
  load(parts);
  EXPECT_EQ(scene_.materials[0].emission, vec3(8, 4, 2));
  ASSERT_EQ(scene_.materials[0].emission_texture, 0);
  EXPECT_TRUE(scene_.textures[0].srgb);
  parts.more = material(R"("emissiveFactor": [1, 0.5, 0.25])");
  load(parts);
  EXPECT_EQ(scene_.materials.back().emission, vec3(1, 0.5f, 0.25f));
  parts.more = material(R"("name": "dark")");
  load(parts);
  EXPECT_EQ(scene_.materials.back().emission, vec3(0));
  EXPECT_EQ(scene_.materials.back().emission_texture, -1) << "multiplies 0";
}

TEST_F(GltfFile, MasksCutOutAndOpaqueOnesDoNot) {
  DisplayImage image{2, 2, 4, std::vector<uint8_t>(16, 200)};
  image.pixels[3] = 10;
  write_png(folder_.file("leaf.png"), image);
  Parts parts;
  parts.primitive = R"("indices": 3, "material": 0)";
  const auto material = [](const std::string& alpha) {
    return R"(, "images": [{"uri": "leaf.png"}], "textures": [{"source": 0}], "materials": [{"name":
        "leaf", )" +
           alpha + R"( "pbrMetallicRoughness": {"baseColorTexture": {"index": 0},
        "metallicFactor": 0}}])";
  };
  parts.more = material(R"("alphaMode": "MASK", "alphaCutoff": 0.25,)");
  load(parts);
  EXPECT_EQ(scene_.materials[0].alpha_texture, 0);
  EXPECT_EQ(scene_.materials[0].alpha_cutoff, 0.25f);
  EXPECT_EQ(scene_.textures[0].texels[3], 10);
  parts.more = material("");
  load(parts);
  EXPECT_EQ(scene_.materials[1].alpha_texture, -1);
  parts.more = material(R"("alphaMode": "BLEND",)");
  options_.leaf_materials = {"leaf"};
  load(parts);
  EXPECT_EQ(scene_.materials[2].alpha_cutoff, 0.5f);
  EXPECT_EQ(scene_.shaders[scene_.materials[2].shader]->name, "leaf");
}

TEST_F(GltfFile, LightsAndCamerasShowTheScene) {
  Parts parts;
  parts.roots = "0, 1, 2";
  parts.nodes = R"({"mesh": 0},
      {"translation": [0, 1, 5], "camera": 0},
      {"translation": [0, 3, 0], "rotation": [-0.7071068, 0, 0, 0.7071068], "extensions":
        {"KHR_lights_punctual": {"light": 0}}})";
  parts.more = R"(, "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5,
      "aspectRatio": 1.5, "znear": 0.1}}], "extensions": {"KHR_lights_punctual": {"lights":
      [{"type": "spot", "name": "a.b", "color": [1, 0.5, 0], "intensity": 7, "range": 9,
        "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.4}}]}})";
  write_all(folder_.file("shot.gltf"), parts.text());
  const Scene scene = load_scene(folder_.file("shot.gltf").string(), shader_table());
  EXPECT_EQ(scene.width, 768);
  EXPECT_EQ(scene.height, 512);
  EXPECT_EQ(scene.camera.eye, vec3(0, 1, 5));
  EXPECT_LT(glm::distance(scene.camera.target, vec3(0, 1, 4)), 1e-6f);
  EXPECT_NEAR(scene.camera.fov_y_deg, 28.6479f, 1e-3f);
  ASSERT_EQ(scene.lights.size(), 1u);
  const Light& light = scene.lights[0];
  EXPECT_EQ(light.name, "a-b");
  EXPECT_EQ(light.type, LightType::spot);
  EXPECT_EQ(light.position, vec3(0, 3, 0));
  EXPECT_LT(glm::distance(light.direction, vec3(0, -1, 0)), 1e-5f) << "a light looks along -z";
  EXPECT_EQ(light.gain, 7);
  EXPECT_EQ(light.range, 9);
  EXPECT_EQ(light.color, vec3(1, 0.5f, 0));
  EXPECT_NEAR(light.outer_angle_deg, 22.918f, 1e-2f);
  // The text that stands for it loads again, from a cache for instance.
  const Scene again = parse_scene(scene.text, scene.file, shader_table());
  EXPECT_EQ(again.lights.size(), 1u);
  EXPECT_EQ(again.instances.size(), scene.instances.size());
}

TEST_F(GltfFile, CamerasThatAreScaledToNothingAreLeftOut) {
  for (const char* scale : {"1, 1, 0", "1, 0, 1"}) {
    Parts parts;
    parts.roots = "0, 1, 2";
    parts.nodes = fmt::format(R"({{"mesh": 0}}, {{"scale": [{}], "camera": 0}},
        {{"translation": [0, 1, 5], "scale": [3, 2, 1], "camera": 0}})",
                              scale);
    parts.more =
        R"(, "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}])";
    write_all(folder_.file("flat.gltf"), parts.text());
    const Scene scene = load_scene(folder_.file("flat.gltf").string(), shader_table());
    EXPECT_EQ(scene.camera.eye, vec3(0, 1, 5)) << scale;
    EXPECT_EQ(scene.camera.up, vec3(0, 1, 0)) << scale;
  }
}

TEST_F(GltfFile, FarCamerasLookWhereTheyPoint) {
  Parts parts;
  parts.roots = "0, 1, 2";
  // A group far away, from which its child comes back.
  parts.nodes = R"({"mesh": 0},
      {"translation": [3e5, 0, 3e5], "rotation": [0, 0.3826834, 0, 0.9238795], "camera": 0},
      {"children": [3], "translation": [9e8, 0, 0]}, {"children": [4], "translation": [9e8, 0, 0]},
      {"children": [5], "translation": [-9e8, 0, 0]}, {"mesh": 0, "translation": [-9e8, 0, 0]})";
  parts.more =
      R"(, "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}])";
  write_all(folder_.file("far.gltf"), parts.text());
  const Camera camera = load_scene(folder_.file("far.gltf").string(), shader_table()).camera;
  const vec3 forward = glm::normalize(camera.target - camera.eye);
  EXPECT_LT(glm::distance(forward, glm::normalize(vec3(-1, 0, -1))), 1e-4f);
}

TEST_F(GltfFile, PlacedBySceneFilesLikeAnyGeometry) {
  Parts parts;
  parts.roots = "0, 1";
  parts.nodes = R"({"mesh": 0}, {"mesh": 0, "translation": [0, 0, 4]})";
  write_all(folder_.file("two.gltf"), parts.text());
  const std::string text = R"({"camera": {"fit": true}, "lights": [], "geometry": [
      {"file": "two.gltf", "name": "two", "prototype": true, "transform": {"scale": 2}},
      {"instances_of": "two", "transforms": [{}, {"translate": [0, 0, 100]}]}]})";
  const Scene scene = parse_scene(text, folder_.file("scene.json"), shader_table());
  ASSERT_EQ(scene.instances.size(), 4u);
  EXPECT_EQ(scene.instances[3].world_from_local[3], vec3(0, 0, 108));
  EXPECT_EQ(scene.prototypes[0].name, "two");
}

TEST_F(GltfFile, RequiredExtensionsAreRefusedByName) {
  for (const char* name :
       {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "EXT_texture_webp"}) {
    Parts parts;
    parts.buffer = R"("uri": "missing.bin", "byteLength": 140)";
    parts.more = fmt::format(R"(, "extensionsRequired": ["{}"])", name);
    expect_error(parts, fmt::format("needs the extension {}", name));
  }
}

TEST_F(GltfFile, MistakesAreNamed) {
  const auto with = [](auto change) {
    Parts parts;
    change(parts);
    return parts;
  };
  expect_error(with([](Parts& p) { p.asset = R"({"version": "1.0"})"; }), "only glTF 2");
  expect_error(with([](Parts& p) { p.roots = "7"; }), "node 7 of 1");
  expect_error(with([](Parts& p) { p.nodes = R"({"mesh": 4})"; }), "mesh 4 of 1");
  expect_error(with([](Parts& p) { p.nodes = R"({"mesh": 0, "children": [0]})"; }),
               "has two parents or is its own");
  expect_error(
      with([](Parts& p) {
        p.nodes = R"({"children": [1], "translation": [0, 9e8, 0]},
                   {"camera": 0, "translation": [0, 9e8, 0]})";
        p.more =
            R"(, "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}])";
      }),
      "/nodes/1: lies too far away");
  expect_error(with([](Parts& p) { p.nodes = R"({"mesh": 0, "scale": [1e300, 1, 1]})"; }),
               "transform is not finite");
  expect_error(with([](Parts& p) {
                 p.roots = "0, 0";
                 p.nodes = R"({"mesh": 0})";
               }),
               "has two parents or is its own");
  expect_error(with([](Parts& p) {
                 p.nodes = R"({"children": [1]}, {"children": [2]}, {"mesh": 0, "children": [1]})";
               }),
               "has two parents or is its own");
  expect_error(with([](Parts& p) { p.primitive = R"("indices": 99)"; }),
               "indices accessor out of bounds");
  expect_error(with([](Parts& p) { p.primitive = R"("indices": 0)"; }), "unexpected type");
  expect_error(with([](Parts& p) { p.primitive = R"("indices": 3, "material": 2)"; }),
               "material 2 of 0");
  expect_error(with([](Parts& p) { p.attributes = R"("NORMAL": 1)"; }), "no positions");
  expect_error(with([](Parts& p) {
                 p.accessors.replace(p.accessors.find("\"count\": 4"), 10, "\"count\": 5");
               }),
               "reaches beyond its buffer");
  expect_error(with([](Parts& p) {
                 p.views.replace(p.views.find("\"byteOffset\": 0"), 15, "\"byteOffset\": 120");
               }),
               "reaches beyond its buffer");
  expect_error(with([](Parts& p) {
                 p.accessors.replace(p.accessors.find("\"count\": 6"), 10,
                                     "\"count\": 4000000000000000000");
               }),
               "reaches beyond its buffer");
  expect_error(with([](Parts& p) { p.buffer = R"("uri": "quad.bin", "byteLength": 4000000000)"; }),
               "cannot be read");
  expect_error(with([](Parts& p) { p.views = R"({"buffer": 7, "byteLength": 48})"; }),
               "cannot be read");
  std::string bytes = quad_bytes();
  bytes[128] = 9;  // an index
  write_all(folder_.file("quad.bin"), bytes);
  expect_error({}, "index 0 is 9 of 4 vertices");
  const float infinite = std::numeric_limits<float>::infinity();
  std::memcpy(bytes.data(), &infinite, sizeof(infinite));
  write_all(folder_.file("quad.bin"), bytes);
  expect_error({}, "vertex 0 is not finite");
  std::filesystem::remove(folder_.file("quad.bin"));
  expect_error({}, "cannot be read");
}

/// Each cut of a file, and each byte of it changed, is read or refused with an Error.
TEST_F(GltfFile, TellsWhichLengthOfAGlbIsWrong) {
  const std::string whole = make_glb(Parts().text(), quad_bytes());
  write_all(folder_.file("a.glb"), whole.substr(0, whole.size() - 1));
  EXPECT_ERROR(read_gltf(folder_.file("a.glb")), ErrorKind::input,
               fmt::format("says it has {} bytes, and has {}", whole.size(), whole.size() - 1));
  std::string damaged = whole;
  damaged.replace(12, 4, "\xff\xff\xff\x7f");
  write_all(folder_.file("a.glb"), damaged);
  EXPECT_ERROR(read_gltf(folder_.file("a.glb")), ErrorKind::input,
               "says its JSON has 2147483647 bytes");
}

TEST_F(GltfFile, NoDamageGetsThrough) {
  Parts parts;
  parts.buffer = R"("byteLength": 140)";
  const std::string whole = make_glb(parts.text(), quad_bytes());
  int refused = 0;
  const auto try_file = [&](const std::string& bytes) {
    write_all(folder_.file("a.glb"), bytes);
    try {
      read_gltf(folder_.file("a.glb"));
    } catch (const Error& error) {
      EXPECT_TRUE(error.kind() == ErrorKind::input || error.kind() == ErrorKind::limit);
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      ++refused;
    }
  };
  for (size_t length = 0; length < whole.size(); length += 3) try_file(whole.substr(0, length));
  EXPECT_EQ(refused, static_cast<int>((whole.size() + 2) / 3));
  for (size_t i = 0; i < whole.size(); i += 2) {
    std::string changed = whole;
    changed[i] = static_cast<char>(changed[i] ^ (i % 4 == 0 ? 0x80 : 0x05));
    try_file(changed);
  }
  EXPECT_GT(refused, static_cast<int>(whole.size() / 2));
}

}  // namespace
}  // namespace relume
