#include <gtest/gtest.h>

#include <cmath>

#include "core/image/image_io.h"
#include "core/math/transform.h"
#include "core/scene/io/json_geometry.h"
#include "core/scene/io/json_node.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace relume {
namespace {

/// A complete scene, with one of its sections replaced.
std::string scene_text(const std::string& section = "", const std::string& text = "") {
  std::vector<std::pair<std::string, std::string>> sections{
      {"name", R"("test")"},
      {"image", R"({"width": 64, "height": 32})"},
      {"camera", R"({"eye": [0, 0, 5], "target": [0, 0, 0]})"},
      {"materials", R"([{"name": "clay", "shader": "lambert", "diffuse": [0.1, 0.2, 0.3]}])"},
      {"geometry", R"([{"name": "ball", "generator": "sphere", "rings": 8, "material": "clay"}])"},
      {"lights", R"([{"name": "key", "type": "point", "position": [1, 2, 3], "gain": 7}])"},
  };
  bool replaced = section.empty();
  std::string out = "{";
  for (auto& [key, value] : sections) {
    if (key == section) value = text;
    replaced = replaced || key == section;
    out += (out.size() > 1 ? ",\n\"" : "\n\"") + key + "\": " + value;
  }
  if (!replaced) out += ",\n\"" + section + "\": " + text;
  return out + "\n}\n";
}

Scene parse(const std::string& text) {
  return parse_scene(text, "folder/scene.json", shader_table());
}

void expect_input_error(const std::string& text, const std::string& part) {
  SCOPED_TRACE(text);
  EXPECT_ERROR(parse(text), ErrorKind::input, part);
}

TEST(SceneJson, ReadsEmission) {
  const auto emission = [](const std::string& value) {
    return scene_text("materials",
                      R"([{"name": "clay", "shader": "lambert", "emission": )" + value + "}]");
  };
  EXPECT_EQ(parse(emission("[4, 2, 0.5]")).materials[0].emission, vec3(4, 2, 0.5f));
  EXPECT_EQ(parse(emission("3")).materials[0].emission, vec3(3));
  EXPECT_FALSE(has_emission(parse(emission("0"))));
  EXPECT_TRUE(parse(emission("3")).materials[0].parameters.empty());
  expect_input_error(emission("[1, -1, 0]"), "/emission");
  expect_input_error(emission("1e30"), "/emission");
  expect_input_error(emission("\"bright\""), "/emission");
  expect_input_error(emission(R"({"texture": "none.png"})"), "none.png");
}

TEST(SceneJson, ReadsWhatTheFileSays) {
  const std::string text = scene_text();
  const Scene scene = parse(text);
  EXPECT_EQ(scene.name, "test");
  EXPECT_EQ(scene.text, text);
  EXPECT_TRUE(scene.file.is_absolute());
  EXPECT_EQ(scene.width, 64);
  EXPECT_EQ(scene.height, 32);
  ASSERT_EQ(scene.materials.size(), 1u);
  EXPECT_EQ(scene.shaders[scene.materials[0].shader]->name, "lambert");
  EXPECT_EQ(scene.materials[0].parameters.at(0).value, vec3(0.1f, 0.2f, 0.3f));
  ASSERT_EQ(scene.instances.size(), 1u);
  EXPECT_EQ(scene.prototypes.at(0).name, "ball");
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_EQ(scene.lights[0].position, vec3(1, 2, 3));
  EXPECT_EQ(scene.lights[0].gain, 7);
}

TEST(SceneJson, AllowsComments) {
  EXPECT_EQ(parse("// first\n" + scene_text() + "/* last */").name, "test");
}

TEST(SceneJson, NamesLineAndColumnOfSyntaxErrors) {
  expect_input_error("{\n  \"name\": \"a\",\n  \"image\": }\n", "scene.json: line 3, column 12");
  expect_input_error("", "line 1, column 1");
  expect_input_error("{\"name\": 1e999}", "number overflow");
  expect_input_error(scene_text().substr(0, 120), "syntax error");
}

TEST(SceneJson, EveryTruncationIsOneInputError) {
  const std::string text = scene_text();
  for (size_t length = 0; length + 2 < text.size(); ++length) {
    expect_input_error(text.substr(0, length), "scene.json");
  }
}

TEST(SceneJson, SuggestsTheNearestKey) {
  expect_input_error(scene_text("camera", R"({"eyes": [0,0,5], "target": [0,0,0]})"),
                     "/camera/eyes: is an unknown key; did you mean \"eye\"?");
  expect_input_error(scene_text("lihgts", "[]"), "did you mean \"lights\"?");
  expect_input_error(scene_text("materials", R"([{"name": "clay", "shader": "lambert",
      "exponent": 3}])"),
                     "/materials/0/exponent: is an unknown key");
}

TEST(SceneJson, RejectsDuplicateKeys) {
  expect_input_error(scene_text("name", R"("a", "name": "b")"), "\"name\" is given twice");
  // The same key in two objects is fine.
  EXPECT_NO_THROW(parse(
      scene_text("lights", R"([{"name": "a", "type": "point"}, {"name": "b", "type": "point"}])")));
}

TEST(SceneJson, NamesTheFieldThatIsWrong) {
  const auto material = [](const std::string& diffuse) {
    return scene_text("materials",
                      R"([{"name": "clay", "shader": "lambert", "diffuse": )" + diffuse + "}]");
  };
  expect_input_error(material(R"([0.1, "x", 0.3])"), "/materials/0/diffuse/1: is not a number");
  expect_input_error(material("[0.1, 0.2]"), "/materials/0/diffuse: is not a list of three");
  expect_input_error(material("[0.1, 0.2, 1.5]"), "/materials/0/diffuse/2: 1.5 is out of range");
  expect_input_error(material("-1"), "/materials/0/diffuse: -1 is out of range");
  expect_input_error(material("true"), "/materials/0/diffuse: is not a number");
  expect_input_error(material(R"({"texture": "no.png"})"), "/materials/0/diffuse/texture");
  expect_input_error(material(R"({"scale": 1})"), "lacks \"texture\"");
  expect_input_error(scene_text("image", R"({"width": 1.5, "height": 1})"), "/image/width: 1.5");
  expect_input_error(scene_text("image", R"({"width": 0, "height": 1})"), "/image/width: 0");
  expect_input_error(scene_text("image", R"({"width": 8})"), "lacks \"height\"");
  expect_input_error(scene_text("exposure", "100"), "/exposure: 100 is out of range");
  expect_input_error(scene_text("instancing", R"("often")"), "auto, flatten, instance");
}

TEST(SceneJson, ReadsGgxWithAChannelOfATextureAndANormalMap) {
  const test::TemporaryFolder folder;
  write_png(folder.file("map.png"), {2, 2, 4, std::vector<uint8_t>(16, 200)});
  const std::string text = scene_text("materials", R"([{"name": "clay", "shader": "ggx",
      "base_color": [0.5, 0.25, 1], "metallic": 1,
      "roughness": {"texture": "map.png", "channel": "g", "scale": 0.5},
      "normal_map": {"texture": "map.png", "scale": 2}}])");
  const Scene scene = parse_scene(text, folder.file("scene.json"), shader_table());
  const Material& material = scene.materials.at(0);
  ASSERT_EQ(material.parameters.size(), 3u);
  EXPECT_EQ(material.parameters[0].value, vec3(0.5f, 0.25f, 1));
  EXPECT_EQ(material.parameters[2].name, "roughness");
  EXPECT_EQ(material.parameters[2].channel, 1);
  EXPECT_EQ(material.parameters[2].value.x, 0.5f);
  EXPECT_EQ(material.normal_texture, material.parameters[2].texture);
  EXPECT_EQ(material.normal_scale, 2);
}

TEST(SceneJson, RejectsMaterialsThatMakeNoSense) {
  expect_input_error(scene_text("materials", R"([{"name": "a", "shader": "ggx", "diffuse": 1}])"),
                     "/diffuse: is an unknown key");
  expect_input_error(scene_text("materials", R"([{"name": "a", "shader": "ggx",
      "metallic": 1.5}])"),
                     "/metallic: 1.5 is out of range");
  expect_input_error(scene_text("materials", R"([{"name": "a", "shader": "kajiya-kay",
      "normal_map": {"texture": "a.png"}}])"),
                     "/normal_map: is an unknown key");
  expect_input_error(scene_text("materials", R"([{"name": "a", "shader": "ggx",
      "base_color": {"texture": "a.png", "channel": "g"}}])"),
                     "/channel: is an unknown key");
  expect_input_error(scene_text("materials", R"([{"shader": "lambert"}])"), "lacks \"name\"");
  expect_input_error(scene_text("materials", R"([{"name": "a", "shader": "lambertian"}])"),
                     "lambert, phong, kajiya-kay, leaf, ggx");
  expect_input_error(scene_text("materials", R"([{"name": "clay", "shader": "lambert"},
      {"name": "clay", "shader": "phong"}])"),
                     "taken by another material");
  expect_input_error(scene_text("materials", R"([{"name": "clay", "shader": "kajiya-kay"}])"),
                     "has a shader for strands");
  expect_input_error(scene_text("materials", R"([{"name": "clay", "shader": "lambert",
      "merge": {"position": "average"}}])"),
                     "/merge/position: is an unknown key");
  expect_input_error(scene_text("materials", R"([{"name": "clay", "shader": "lambert",
      "merge": {"normal": "median"}}])"),
                     "average, representative");
}

TEST(SceneJson, ReadsMergeChoices) {
  const Scene scene = parse(scene_text("materials", R"([{"name": "clay", "shader": "lambert",
      "merge": {"normal": "representative"}}])"));
  ASSERT_EQ(scene.materials[0].merges.size(), 1u);
  EXPECT_EQ(scene.materials[0].merges[0].first, "normal");
  EXPECT_EQ(scene.materials[0].merges[0].second, Merge::representative);
}

TEST(SceneJson, RejectsGeometryThatMakesNoSense) {
  const auto geometry = [](const std::string& entry) {
    return scene_text("geometry", "[" + entry + "]");
  };
  expect_input_error(geometry(""), "/geometry: places nothing");
  expect_input_error(geometry(R"({"name": "a"})"), "/geometry/0: does not say what it is");
  expect_input_error(geometry(R"({"generator": "cube", "material": "clay"})"),
                     "sphere, plane, box");
  expect_input_error(geometry(R"({"generator": "sphere", "material": "mud"})"),
                     "\"mud\" is no material of this file; give one of: clay");
  expect_input_error(geometry(R"({"generator": "sphere", "rings": 2, "material": "clay"})"),
                     "/geometry/0/rings: 2 is out of range");
  expect_input_error(geometry(R"({"generator": "sphere", "material": "clay", "prototype": true})"),
                     "places nothing");
  expect_input_error(geometry(R"({"file": "x.fbx"})"),
                     "give an .obj, .gltf, .glb, .pbrt, .ply or .hair file");
  expect_input_error(geometry(R"({"file": "missing.obj"})"), "folder/missing.obj: cannot open");
  expect_input_error(geometry(R"({"instances_of": "ball", "transforms": []})"),
                     "is no earlier geometry");
  expect_input_error(geometry(R"({"generator": "sphere", "material": "clay",
      "transform": {"scale": 0}})"),
                     "/geometry/0/transform/scale: is zero");
  expect_input_error(geometry(R"({"name": "a", "generator": "sphere", "material": "clay"},
      {"name": "a", "generator": "sphere", "material": "clay"})"),
                     "taken by an earlier entry");
}

TEST(SceneJson, LimitsAreErrorsOfTheirOwnKind) {
  EXPECT_ERROR(parse(scene_text("image", R"({"width": 16385, "height": 1})")), ErrorKind::limit,
               "/image/width: 16385 is too many");
  EXPECT_ERROR(parse(scene_text("geometry", R"([{"generator": "hair-ball", "strands": 20000000,
      "strand_materials": ["clay"], "ball_material": "clay"}])")),
               ErrorKind::limit, "/geometry/0/strands");
  std::string deep = "{\"name\": ";
  for (int i = 0; i < 100000; ++i) deep += '[';
  EXPECT_ERROR(parse(deep), ErrorKind::limit, "nested deeper than 64");
  EXPECT_ERROR(parse(scene_text("name", "\"" + std::string(300, 'x') + "\"")), ErrorKind::limit,
               "/name: 300 bytes are too long");
}

TEST(SceneJson, FilesOfMoreThan64MiBAreRefused) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.file("scene.json");
  test::write_all(file, scene_text());
  EXPECT_EQ(load_scene(file.string(), shader_table()).name, "test");
  std::filesystem::resize_file(file, (uint64_t{64} << 20) + 1);
  EXPECT_ERROR(load_scene(file.string(), shader_table()), ErrorKind::limit, "67108865 bytes");
}

TEST(SceneJson, RejectsCamerasThatSeeNothing) {
  expect_input_error(scene_text("camera", R"({"eye": [0, 0, 0], "target": [0, 0, 0]})"),
                     "camera/target");
  expect_input_error(scene_text("camera", R"({"eye": [0, 5, 0], "target": [0, 0, 0]})"),
                     "camera/up");
  expect_input_error(scene_text("camera", R"({"target": [0, 0, 0]})"), "lacks \"eye\"");
}

TEST(SceneJson, FitsTheCameraAroundTheFocus) {
  const Scene scene = parse(scene_text("camera", R"({"fit": true, "direction": [-1, -0.5, -2]})"));
  const CameraRays rays(scene.camera, scene.width, scene.height);
  float closest_px = 1e9f;
  for (int corner = 0; corner < 8; ++corner) {
    const vec3 p((corner & 1) != 0 ? 1.0f : -1.0f, (corner & 2) != 0 ? 1.0f : -1.0f,
                 (corner & 4) != 0 ? 1.0f : -1.0f);
    const CameraRays::Projection at = rays.project(p);
    EXPECT_GT(at.depth, 0);
    const float edge_px =
        std::min({at.film_px.x, at.film_px.y, 64 - at.film_px.x, 32 - at.film_px.y});
    EXPECT_GT(edge_px, 0);
    closest_px = std::min(closest_px, edge_px);
  }
  EXPECT_LT(closest_px, 4);  // no more room than the margin of 10 %
}

TEST(SceneJson, TransformsScaleThenRotateThenTranslate) {
  const JsonDocument document(
      R"({"translate": [10, 0, 0], "rotate_deg": [90, 90, 0], "scale": [2, 1, 1]})", "test");
  const mat4x3 m = read_transform(document.root());
  // x: scaled to 2 x, kept by the turn about x, carried to -z by the turn about y.
  EXPECT_LT(glm::distance(transform_point(m, {1, 0, 0}), vec3(10, 0, -2)), 1e-5f);
  // y: carried to z by the turn about x, then to x by the turn about y.
  EXPECT_LT(glm::distance(transform_point(m, {0, 1, 0}), vec3(11, 0, 0)), 1e-5f);
}

TEST(SceneJson, InstancesApplyTheEntrysOwnTransformFirst) {
  const Scene scene = parse(scene_text("geometry", R"([
      {"name": "ball", "generator": "sphere", "rings": 8, "material": "clay", "prototype": true,
       "transform": {"scale": 2}},
      {"instances_of": "ball", "transforms": [{"translate": [10, 0, 0]}, {"scale": 3}]}])"));
  EXPECT_EQ(scene.prototypes.size(), 1u);
  ASSERT_EQ(scene.instances.size(), 2u);
  EXPECT_EQ(transform_point(scene.instances[0].world_from_local, {1, 0, 0}), vec3(12, 0, 0));
  EXPECT_EQ(transform_point(scene.instances[1].world_from_local, {1, 0, 0}), vec3(6, 0, 0));
  EXPECT_EQ(count_scene(scene).instanced_triangles, 2 * count_scene(scene).triangles);
}

TEST(SceneJson, ScattersWithoutCopyingGeometry) {
  const auto scattered = [](const std::string& min_distance) {
    return scene_text("geometry", R"([
      {"name": "ball", "generator": "sphere", "rings": 8, "material": "clay", "prototype": true},
      {"scatter": ["ball"], "count": 50, "area": [[-100, -100], [100, 100]], "scale": [0.5, 2],
       "min_distance": )" + min_distance +
                                      "}]");
  };
  const Scene scene = parse(scattered("5"));
  EXPECT_EQ(scene.prototypes.size(), 1u);
  EXPECT_EQ(scene.instances.size(), 50u);
  expect_input_error(scattered("90"), "of 50 fit");
}

TEST(SceneJson, ScattersWithinAMillionTimesLargerOrSmaller) {
  const auto scattered = [](const std::string& scale) {
    return scene_text("geometry", R"([
      {"name": "ball", "generator": "sphere", "rings": 8, "material": "clay", "prototype": true},
      {"scatter": ["ball"], "count": 2, "area": [[-1, -1], [1, 1]], "scale": )" +
                                      scale + "}]");
  };
  for (const char* scale : {"1e6", "1e-6", "[1e-6, 1e6]"}) {
    EXPECT_EQ(parse(scattered(scale)).instances.size(), 2u) << scale;
  }
  for (const char* scale : {"1.01e6", "0.99e-6", "[1, 1.01e6]", "[0.99e-6, 1]", "0", "-1"}) {
    expect_input_error(scattered(scale), "is out of range");
  }
}

TEST(SceneJson, RelativeLightsFollowTheScenesUnits) {
  const auto scaled = [](const std::string& scale) {
    std::string text = scene_text("lights", R"([{"name": "key", "position": {"relative": [0, 2, 0]},
        "gain_relative": 3}])");
    const std::string geometry = R"("material": "clay")";
    return text.replace(text.find(geometry), geometry.size(),
                        geometry + R"(, "transform": {"scale": )" + scale + "}");
  };
  const Light small = parse(scaled("1")).lights.at(0);
  const Light large = parse(scaled("100")).lights.at(0);
  EXPECT_NEAR(small.position.y, 2 * std::sqrt(3.0f), 1e-4f);
  EXPECT_NEAR(large.position.y, 100 * small.position.y, 1e-2f);
  EXPECT_NEAR(large.gain, 1e4f * small.gain, large.gain * 1e-5f);
}

TEST(SceneJson, ChecksLights) {
  const auto light = [](const std::string& text) {
    return scene_text("lights", "[{" + text + "}]");
  };
  expect_input_error(light(R"("type": "area")"), "point, spot, directional");
  expect_input_error(light(R"("gain": -1)"), "/lights/0/gain: -1 is out of range");
  expect_input_error(light(R"("type": "spot", "direction": [0, 0, 0])"), "/lights/0/direction");
  expect_input_error(light(R"("type": "spot", "inner_angle_deg": 50, "outer_angle_deg": 40)"),
                     "/lights/0/inner_angle_deg");
  expect_input_error(light(R"("name": "a.b")"), "/lights/0/name: holds a dot");
  expect_input_error(scene_text("lights", R"([{"name": "a"}, {"name": "a"}])"),
                     "/lights/1: the name \"a\" is taken");
  expect_input_error(scene_text("representative_lights", R"([{"name": "low"}])"),
                     "/representative_lights: holds 1 lights");
  expect_input_error(
      scene_text("representative_lights", R"([{"type": "point"}, {"type": "directional"}])"),
      "differ in type");
}

TEST(SceneJson, AimsALightAtItsTarget) {
  const Scene scene = parse(
      scene_text("lights", R"([{"type": "spot", "position": [0, 4, 0], "target": [0, 0, 3]}])"));
  EXPECT_EQ(scene.lights[0].direction, vec3(0, -4, 3));
}

TEST(LightFiles, ComeBackAsTheyWere) {
  std::vector<Light> lights(3);
  lights[0].name = "key \"one\"";
  lights[0].position = {0.1f, 1.0f / 3.0f, -1e-20f};
  lights[0].gain = 123456.789f;
  lights[1].name = "spot";
  lights[1].type = LightType::spot;
  lights[1].direction = {1, 2, 3};
  lights[1].inner_angle_deg = 0;
  lights[1].outer_angle_deg = 89.5f;
  lights[1].falloff = false;
  lights[1].range = 1.25f;
  lights[2].name = "sun";
  lights[2].type = LightType::directional;
  lights[2].color = {0.3f, 0, 1e20f};
  lights[2].mute = true;
  lights[2].casts_shadow = false;
  const std::vector<Light> read = parse_lights(format_lights(lights), "lights.json");
  ASSERT_EQ(read.size(), lights.size());
  for (size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].name, lights[i].name);
    EXPECT_EQ(read[i].type, lights[i].type);
    EXPECT_EQ(read[i].position, lights[i].position);
    EXPECT_EQ(read[i].direction, lights[i].direction);
    EXPECT_EQ(read[i].inner_angle_deg, lights[i].inner_angle_deg);
    EXPECT_EQ(read[i].outer_angle_deg, lights[i].outer_angle_deg);
    EXPECT_EQ(read[i].falloff, lights[i].falloff);
    EXPECT_EQ(read[i].range, lights[i].range);
    EXPECT_EQ(read[i].color, lights[i].color);
    EXPECT_EQ(read[i].gain, lights[i].gain);
    EXPECT_EQ(read[i].mute, lights[i].mute);
    EXPECT_EQ(read[i].casts_shadow, lights[i].casts_shadow);
  }
  EXPECT_TRUE(parse_lights(format_lights({}), "none").empty());
}

TEST(LightFiles, KeepTheSignOfZero) {
  const auto read = parse_lights(R"({"lights": [{"direction": [-0.0, -1, 0]}]})", "lights.json");
  const std::string text = format_lights(read);
  const auto again = parse_lights(text, "lights.json");
  EXPECT_TRUE(std::signbit(again[0].direction.x));
  EXPECT_FALSE(std::signbit(again[0].direction.z));
  EXPECT_EQ(format_lights(again), text);
}

TEST(LightFiles, AcceptAWholeScene) {
  EXPECT_EQ(parse_lights(scene_text(), "scene.json").at(0).name, "key");
  EXPECT_ERROR(parse_lights(R"({"lamps": []})", "l.json"), ErrorKind::input, "l.json: /lamps");
  EXPECT_ERROR(parse_lights(R"({"lights": [{"gain_relative": 1}]})", "l.json"), ErrorKind::input,
               "needs a scene's bounds");
}

}  // namespace
}  // namespace relume
