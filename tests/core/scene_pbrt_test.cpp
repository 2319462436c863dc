#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/image/image_io.h"
#include "core/math/transform.h"
#include "core/scene/io/load_scene.h"
#include "core/scene/io/pbrt.h"
#include "core/scene/io/pbrt_materials.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace relume {
namespace {

using test::TemporaryFolder;
using test::write_all;

const std::string view = R"(
LookAt 0 1 -5  0 1 0  0 1 0   # from -z: x to the right
Camera "perspective" "float fov" [ 40 ]
Film "rgb" "integer xresolution" [ 30 ] "integer yresolution" 20 "string filename" "a.exr"
WorldBegin
)";
const std::string triangle =
    R"(Shape "trianglemesh" "point3 P" [ 0 0 0  1 0 0  0 1 0 ] "integer indices" [ 0 1 2 ])"
    "\n";

class PbrtFile : public testing::Test {
 protected:
  Scene load(const std::string& text) {
    write_all(folder_.file("a b.pbrt"), text);
    return load_scene(folder_.file("a b.pbrt").string(), shader_table());
  }
  /// Without a camera of the file: its axes as they are.
  Scene load_shapes(const std::string& text) { return load("WorldBegin\n" + text); }
  void expect_error(const std::string& text, const std::string& part,
                    ErrorKind kind = ErrorKind::input) {
    SCOPED_TRACE(text);
    EXPECT_ERROR(load(text), kind, part);
  }
  static const Mesh& mesh(const Scene& scene, size_t prototype = 0) {
    return std::get<Mesh>(scene.prototypes.at(prototype).shapes.at(0));
  }
  static const Curves& curves(const Scene& scene, size_t shape = 0) {
    return std::get<Curves>(scene.prototypes.at(0).shapes.at(shape));
  }
  static std::string_view shader(const Scene& scene, size_t material = 0) {
    return scene.shaders[scene.materials.at(material).shader]->name;
  }
  static vec3 parameter(const Scene& scene, const std::string& name, size_t material = 0) {
    for (const MaterialParameter& p : scene.materials.at(material).parameters) {
      if (p.name == name) return p.value;
    }
    throw std::out_of_range(name);
  }
  /// stderr of a load.
  std::string notes_of(const std::string& text) {
    testing::internal::CaptureStderr();
    load_shapes(text);
    return testing::internal::GetCapturedStderr();
  }

  TemporaryFolder folder_;
};

TEST_F(PbrtFile, CameraFilmAndLightsShowWhatPbrtShows) {
  const Scene scene = load(view + R"(
      AttributeBegin
        Translate 1 2 3
        LightSource "point" "rgb I" [ 2 4 8 ] "float scale" 0.5
      AttributeEnd
      LightSource "spot" "point3 from" [ 1 5 0 ] "point3 to" [ 1 0 0 ] "float coneangle" 40
        "float conedeltaangle" 10
      LightSource "distant" "point3 from" [ 1 0 0 ] "point3 to" [ 0 0 0 ] "rgb L" [ 3 3 3 ])" +
                           triangle);
  EXPECT_EQ(scene.width, 30);
  EXPECT_EQ(scene.height, 20);
  EXPECT_EQ(scene.camera.eye, vec3(0, 1, -5));
  EXPECT_NEAR(scene.camera.fov_y_deg, 40, 1e-4f) << "of the shorter side";
  // The left-handed file has +x on the right of the picture; ours, mirrored in x, has it there too.
  const CameraRays rays(scene.camera, scene.width, scene.height);
  const Instance& world = scene.instances.at(0);
  const vec3 corner = transform_point(world.world_from_local, {1, 0, 0});
  EXPECT_GT(rays.project(corner).film_px.x, 15);
  EXPECT_GT(rays.project(corner).depth, 0);
  EXPECT_EQ(corner, vec3(-1, 0, 0));
  ASSERT_EQ(scene.lights.size(), 3u);
  EXPECT_EQ(scene.lights[0].position, vec3(-1, 2, 3));
  EXPECT_EQ(scene.lights[0].gain * scene.lights[0].color, vec3(1, 2, 4));
  EXPECT_EQ(scene.lights[1].type, LightType::spot);
  EXPECT_EQ(scene.lights[1].outer_angle_deg, 40);
  EXPECT_EQ(scene.lights[1].inner_angle_deg, 30);
  EXPECT_LT(glm::distance(scene.lights[1].direction, vec3(0, -5, 0)), 1e-5f);
  EXPECT_EQ(scene.lights[2].type, LightType::directional);
  EXPECT_EQ(scene.lights[2].direction, vec3(1, 0, 0));
}

TEST_F(PbrtFile, ColoursComeInEachOfItsForms) {
  const auto gain = [&](const std::string& color) {
    const Scene scene = load(view + "LightSource \"point\" " + color + triangle);
    return scene.lights.at(0).gain * scene.lights[0].color;
  };
  EXPECT_EQ(gain(R"("color I" [ 1 2 4 ])"), vec3(1, 2, 4));
  EXPECT_EQ(gain(R"("spectrum I" [ 400 1  500 3 ])"), vec3(2)) << "the mean";
  EXPECT_EQ(gain(R"("spectrum I" "stdillum-D65")"), vec3(1));
  EXPECT_EQ(gain(R"("blackbody I" [ 6500 ])"), vec3(1));
  EXPECT_EQ(gain(R"("blackbody I" [ 6500 7 ] "rgb scale" [ 1 .5 .5 ])"), vec3(7, 3.5f, 3.5f));
  EXPECT_EQ(gain(R"("rgb I" [ 0 0 0 ])"), vec3(0));
}

TEST_F(PbrtFile, ACameraThatFlipsAnAxisLeavesTheWorldAsItIs) {
  const Scene scene = load("Scale -1 1 1\n" + view + triangle);
  EXPECT_EQ(scene.instances.at(0).world_from_local, identity_transform());
  const CameraRays rays(scene.camera, scene.width, scene.height);
  EXPECT_LT(rays.project({1, 0, 0}).film_px.x, 15);
}

TEST_F(PbrtFile, TallFilmsTurnTheFieldOfView) {
  std::string text = view;
  text.replace(text.find("[ 30 ]"), 6, "10");
  const Scene scene = load(text + triangle);
  EXPECT_NEAR(std::tan(radians_from_degrees(scene.camera.fov_y_deg) / 2),
              2 * std::tan(radians_from_degrees(20)), 1e-4f);
}

TEST_F(PbrtFile, TransformsComposeAndScopesEnd) {
  const Scene scene = load_shapes(R"(
      CoordinateSystem "origin"
      AttributeBegin
        Translate 10 0 0
        Rotate 90 0 0 1
        Scale 2 2 2
        )" + triangle + R"(
        CoordSysTransform "origin"
        ConcatTransform [ 1 0 0 0  0 1 0 0  0 0 1 0  0 0 7 1 ]
        )" + triangle + R"(
        Transform [ 0 0 1 0  0 1 0 0  1 0 0 0  0 0 0 1 ]
        )" + triangle + R"(
      AttributeEnd
      TransformBegin
        Translate 0 100 0
        Material "matte"
      TransformEnd
      )" + triangle);
  const std::vector<vec3>& p = mesh(scene).positions;
  ASSERT_EQ(p.size(), 12u);
  EXPECT_LT(glm::distance(p[1], vec3(10, 2, 0)), 1e-5f);
  EXPECT_EQ(p[4], vec3(1, 0, 7));
  EXPECT_EQ(p[7], vec3(0, 0, 1));
  EXPECT_EQ(p[10], vec3(1, 0, 0));
  EXPECT_EQ(scene.materials.at(mesh(scene).materials[3]).name, "matte");
}

TEST_F(PbrtFile, ObjectsArePlacedWithBothTransforms) {
  const Scene scene = load(view + R"(
      ObjectBegin "tuft"
        Translate 0 0 1
        )" + triangle + R"(
      ObjectEnd
      AttributeBegin Translate 5 0 0 ObjectInstance "tuft" AttributeEnd
      AttributeBegin Scale 2 2 2 ObjectInstance "tuft" AttributeEnd)");
  ASSERT_EQ(scene.instances.size(), 2u);
  EXPECT_EQ(scene.prototypes.size(), 1u);
  EXPECT_EQ(transform_point(scene.instances[0].world_from_local, mesh(scene).positions[1]),
            vec3(-6, 0, 1));
  EXPECT_EQ(transform_point(scene.instances[1].world_from_local, mesh(scene).positions[1]),
            vec3(-2, 0, 2));
}

TEST_F(PbrtFile, CurvesBecomeStrandsThatFollowThem) {
  const Scene scene = load_shapes(R"(
      Material "hair" "rgb color" [ .5 .25 .1 ]
      Shape "curve" "point3 P" [ 0 0 0  0 1 0  0 2 0  0 3 0 ] "float width" 0.5
      Scale 2 2 2
      Shape "curve" "string basis" "bspline" "point3 P" [ 0 0 0  6 0 0  6 6 0  0 6 0  0 0 0 ]
        "float width0" 1 "float width1" 0)");
  const Curves& strands = curves(scene);
  ASSERT_EQ(strands.offsets.size(), 3u);
  EXPECT_EQ(strands.offsets[1], 2u) << "a straight one needs no joint";
  EXPECT_EQ(strands.points[1], vec4(0, 3, 0, 0.25f));
  // A uniform cubic B-spline starts at (P0 + 4 P1 + P2) / 6.
  EXPECT_LT(glm::distance(strands.points[2], vec4(10, 2, 0, 1)), 1e-5f);
  const vec4 end = strands.points.back();
  EXPECT_LT(glm::distance(vec3(end), vec3(2, 10, 0)), 1e-5f);
  EXPECT_NEAR(end.w, 0.01f, 1e-6f) << "tips taper to a hundredth";
  EXPECT_GT(strands.points.size(), 12u);
  for (size_t i = 3; i + 1 < strands.points.size(); ++i) {
    const vec3 a = glm::normalize(vec3(strands.points[i]) - vec3(strands.points[i - 1]));
    const vec3 b = glm::normalize(vec3(strands.points[i + 1]) - vec3(strands.points[i]));
    EXPECT_GT(glm::dot(a, b), std::cos(0.4f)) << i;
  }
  EXPECT_EQ(shader(scene), "kajiya-kay");
  EXPECT_EQ(parameter(scene, "diffuse"), vec3(0.5f, 0.25f, 0.1f));
}

TEST_F(PbrtFile, MeshesComeFromPlyBilinearPatchesSpheresAndDisks) {
  write_all(folder_.file("one.ply"),
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
            "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
            "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  const Scene scene = load_shapes(R"(
      Shape "plymesh" "string filename" "one.ply"
      Shape "bilinearmesh" "point3 P" [ 0 0 0  1 0 0  0 1 0  1 1 0 ]
      Shape "disk" "float radius" 2
      Shape "sphere" "float radius" 3
      Shape "cylinder")");
  ASSERT_EQ(scene.prototypes.at(0).shapes.size(), 2u) << "with and without normals";
  EXPECT_EQ(mesh(scene).triangles.size(), 1u + 2 + 62);
  EXPECT_EQ(mesh(scene).triangles[2], uvec3(4, 6, 5));
  Bounds bounds;
  for (const vec3 p : std::get<Mesh>(scene.prototypes[0].shapes[1]).positions) bounds.extend(p);
  EXPECT_NEAR(bounds.high.y, 3, 1e-3f);
}

TEST_F(PbrtFile, MaterialsBecomeTheNearestOfOurs) {
  const Scene scene = load_shapes(R"(
      Material "diffuse" "rgb reflectance" [ .1 .2 .3 ]
      )" + triangle + R"(
      Material "coateddiffuse" "rgb reflectance" [ .4 .5 .6 ] "float roughness" 0.0625
      )" + triangle + R"(
      Material "plastic" "color Kd" [ .4 .5 .6 ] "float roughness" 0.5 "bool remaproughness" "false"
      )" + triangle + R"(
      MakeNamedMaterial "ring" "string type" "conductor" "spectrum eta" "metal-Au-eta"
      NamedMaterial "ring"
      )" + triangle + R"(
      Material "metal" "rgb eta" [ 1.5 1.5 1.5 ] "rgb k" [ 0 0 0 ]
      )" + triangle + R"(
      Material "translucent" "rgb Kd" [ .8 .4 .2 ] "rgb reflect" [ .5 .5 .5 ] "rgb transmit" [ .25 .25 .25 ]
      )" + triangle + R"(
      Material "interface"
      )" + triangle);
  ASSERT_EQ(scene.materials.size(), 6u);
  EXPECT_EQ(shader(scene, 0), "lambert");
  EXPECT_EQ(parameter(scene, "diffuse", 0), vec3(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(shader(scene, 1), "ggx");
  EXPECT_EQ(parameter(scene, "base_color", 1), vec3(0.4f, 0.5f, 0.6f));
  EXPECT_NEAR(parameter(scene, "roughness", 1).x, 0.5f, 1e-5f) << "alpha = sqrt(0.0625)";
  EXPECT_NEAR(parameter(scene, "roughness", 2).x, std::sqrt(0.5f), 1e-5f) << "alpha = 0.5";
  EXPECT_EQ(scene.materials[3].name, "ring");
  EXPECT_EQ(parameter(scene, "metallic", 3).x, 1);
  EXPECT_NEAR(parameter(scene, "base_color", 3).z, 0.336f, 1e-6f);
  EXPECT_NEAR(parameter(scene, "base_color", 4).y, 0.04f, 1e-6f) << "of eta 1.5";
  EXPECT_EQ(shader(scene, 5), "leaf");
  EXPECT_EQ(parameter(scene, "diffuse", 5), vec3(0.4f, 0.2f, 0.1f));
  EXPECT_EQ(parameter(scene, "transmit", 5), vec3(0.2f, 0.1f, 0.05f));
  EXPECT_EQ(mesh(scene).triangles.size(), 6u) << "what has no surface is not seen";
}

TEST_F(PbrtFile, AreaLightsAreSurfacesThatEmit) {
  const Scene scene = load_shapes(R"(
      Material "diffuse" "rgb reflectance" [ .1 .2 .3 ]
      )" + triangle + R"(
      AttributeBegin
        AreaLightSource "diffuse" "rgb L" [ 4 2 1 ] "float scale" 3
        )" + triangle + triangle + R"(
        TransformBegin
          AreaLightSource "diffuse"
        TransformEnd
        )" + triangle + R"(
        AreaLightSource "disco" "rgb L" [ 9 9 9 ]
        )" + triangle + R"(
      AttributeEnd
      )" + triangle);
  ASSERT_EQ(scene.materials.size(), 3u);
  EXPECT_EQ(scene.materials[0].emission, vec3(0));
  EXPECT_EQ(scene.materials[1].emission, vec3(12, 6, 3));
  EXPECT_EQ(scene.materials[2].emission, vec3(1)) << "white unless given; no transform undoes it";
  for (int i = 0; i < 3; ++i) EXPECT_EQ(parameter(scene, "diffuse", i), vec3(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(mesh(scene).triangles.size(), 6u);
  const std::string notes =
      notes_of(R"(AreaLightSource "diffuse" "string filename" "a.exr" )" + triangle);
  EXPECT_NE(notes.find("images of area lights are left out"), std::string::npos) << notes;
  EXPECT_EQ(notes_of(R"(AreaLightSource "diffuse" "rgb L" [ 0 0 0 ] )" + triangle), "");
}

TEST_F(PbrtFile, HairPigmentsGiveItsColour) {
  const std::string curve = R"( Shape "curve" "point3 P" [ 0 0 0  0 1 0  0 2 0  0 3 0 ])";
  const vec3 brown =
      parameter(load_shapes(R"(Material "hair" "float eumelanin" 1.3)" + curve), "diffuse");
  EXPECT_GT(brown.x, brown.y);
  EXPECT_GT(brown.y, brown.z);
  EXPECT_EQ(parameter(load_shapes("Material \"hair\"" + curve), "diffuse"), brown);
  const vec3 blond =
      parameter(load_shapes(R"(Material "hair" "float eumelanin" 0.3)" + curve), "diffuse");
  EXPECT_GT(blond.x, brown.x);
}

TEST_F(PbrtFile, TexturesColourAndCutOut) {
  DisplayImage leaf{2, 2, 4, std::vector<uint8_t>(16, 200)};
  leaf.pixels[3] = 0;
  write_png(folder_.file("leaf.png"), leaf);
  const Scene scene = load_shapes(R"(
      Texture "leaf" "spectrum" "imagemap" "string filename" "leaf.png"
      Texture "half" "spectrum" "scale" "texture tex" "leaf" "float scale" 0.5
      Texture "mask" "float" "imagemap" "string filename" "leaf.png"
      Material "diffuse" "texture reflectance" "half"
      Shape "trianglemesh" "point3 P" [ 0 0 0  1 0 0  0 1 0 ] "point2 uv" [ 0 0  1 0  0 1 ]
        "texture alpha" "mask")");
  const MaterialParameter& diffuse = scene.materials.at(0).parameters.at(0);
  EXPECT_EQ(diffuse.value, vec3(0.5f));
  ASSERT_GE(diffuse.texture, 0);
  EXPECT_TRUE(scene.textures[diffuse.texture].srgb);
  ASSERT_GE(scene.materials[0].alpha_texture, 0);
  EXPECT_FALSE(scene.textures[scene.materials[0].alpha_texture].srgb);
  EXPECT_EQ(mesh(scene).uvs.at(1), vec2(1, 0));
  const Scene opacity = load_shapes(R"(
      Texture "leaf" "color" "imagemap" "string filename" "leaf.png"
      Material "uber" "texture opacity" "leaf"
      )" + triangle + R"(
      Material "uber" "rgb opacity" [ .1 .1 .1 ]
      )" + triangle);
  ASSERT_EQ(mesh(opacity).triangles.size(), 1u) << "the second is not seen";
  EXPECT_GE(opacity.materials.at(0).alpha_texture, 0);
}

TEST_F(PbrtFile, TellsOnceWhatIsReadDifferently) {
  const std::string notes = notes_of(R"(
      LightSource "infinite" "rgb L" [ 1 1 1 ]
      LightSource "infinite" "rgb L" [ 2 2 2 ]
      AreaLightSource "diffuse" "rgb L" [ 1 1 1 ]
      Material "velvet"
      )" + triangle + triangle + R"(Shape "hyperboloid")");
  const auto count = [&](const std::string& part) {
    int found = 0;
    for (size_t at = notes.find(part); at != std::string::npos; at = notes.find(part, at + 1)) {
      ++found;
    }
    return found;
  };
  EXPECT_EQ(count("lights of kind \"infinite\" are left out"), 1) << notes;
  EXPECT_EQ(count("area lights are seen, from both sides, but light nothing else"), 1);
  EXPECT_EQ(count("material \"velvet\" is read as grey lambert"), 1);
  EXPECT_EQ(count("shapes of kind \"hyperboloid\" are left out"), 1);
  EXPECT_EQ(count("\n"), 4);
}

TEST_F(PbrtFile, IncludesAreFoundBesideTheSceneAndBesideTheFile) {
  std::filesystem::create_directory(folder_.file("parts"));
  write_all(folder_.file("parts/a.pbrt"), "Include \"parts/b.pbrt\" Include \"b.pbrt\"\n");
  write_all(folder_.file("parts/b.pbrt"), triangle);
  EXPECT_EQ(mesh(load_shapes("Include \"parts/a.pbrt\"")).triangles.size(), 2u);
}

TEST_F(PbrtFile, StandsInSceneFilesAndLoadsAgainFromItsText) {
  const Scene scene = load(view + triangle);
  const Scene again = parse_scene(scene.text, scene.file, shader_table());
  EXPECT_EQ(again.camera.eye, scene.camera.eye);
  EXPECT_EQ(count_scene(again).triangles, 1u);
  const std::string text = R"({"camera": {"fit": true}, "lights": [], "geometry": [
      {"file": "a b.pbrt", "leaf_materials": [], "transform": {"scale": 2}}]})";
  const std::string wrong = R"({"camera": {"fit": true}, "lights": [], "geometry": [
      {"file": "a b.pbrt", "leaf_materials": ["blade"]}]})";
  EXPECT_ERROR(parse_scene(wrong, folder_.file("scene.json"), shader_table()), ErrorKind::input,
               "leaf material \"blade\" is not in it");
  const Scene placed = parse_scene(text, folder_.file("scene.json"), shader_table());
  EXPECT_EQ(placed.instances.at(0).world_from_local[0], vec3(-2, 0, 0));
}

TEST_F(PbrtFile, MistakesNameFileAndLine) {
  expect_error("WorldBegin\n\n  Shap \"sphere\"", "a b.pbrt:3: unknown statement Shap");
  expect_error("Translate 1 2 x", "a b.pbrt:1: \"x\" is no number");
  expect_error("Translate 1 2 1e400", "is no number");
  expect_error("Translate 1 2 inf", "is no number");
  expect_error("Transform [ 1 2 3 ]", "is no number");
  expect_error("Scale 0 0 0 Camera \"perspective\"", "its transform is singular");
  expect_error("LookAt 0 0 0  0 0 0  0 1 0", "a direction is zero");
  expect_error("LookAt 0 0 0  0 1 0  0 1 0", "a direction is zero");
  expect_error("Rotate 20 0 0 0", "a direction is zero");
  expect_error("Transform [ 1 0 0 1  0 1 0 0  0 0 1 0  0 0 0 1 ]", "is not affine and finite");
  expect_error("Shape \"sphere", "does not end");
  expect_error("Shape \"sphere\" \"radius\" 1", "parameter \"radius\" has no type");
  expect_error("Shape \"sphere\" \"float radius\" [ 1", "does not end");
  expect_error("Shape \"sphere\" \"float radius\" \"big\"", "parameter \"radius\" has 0 numbers");
  expect_error("Shape \"sphere\" \"float radius\" -1", "its radius is not above 0");
  expect_error("AttributeEnd", "AttributeEnd ends what has not begun");
  expect_error("ObjectBegin \"a\"\n" + triangle, "an ObjectBegin does not end");
  expect_error("ObjectInstance \"b\"", "there is no object \"b\"");
  expect_error("NamedMaterial \"b\"", "there is no material \"b\"");
  expect_error("Material \"matte\" \"texture Kd\" \"b\"", "there is no texture \"b\"");
  expect_error("CoordSysTransform \"b\"", "there is no system \"b\"");
  expect_error("Texture \"a\" \"color\" \"imagemap\" \"string filename\" \"gone.png\"",
               "a b.pbrt:1");
  expect_error("Shape \"plymesh\" \"string filename\" \"gone.ply\"", "gone.ply");
  expect_error("Shape \"plymesh\" \"string filename\" \"gone.ply.gz\"", "gone.ply.gz");
  expect_error("Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 ]", "has 4 numbers");
  expect_error(
      "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ] \"integer indices\" "
      "[ 0 1 3 ]",
      "index 2 is 3 of 3 vertices");
  expect_error("Shape \"curve\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ]", "make no curve of degree 3");
  expect_error("Shape \"curve\" \"integer degree\" 9 \"point3 P\" [ 0 0 0 ]", "degree 9");
  expect_error("WorldBegin", "shows no shape that is read");
  expect_error("Include \"gone.pbrt\"", "a b.pbrt:1: includes \"gone.pbrt\", which is missing");
  expect_error("Film \"rgb\" \"integer xresolution\" 1000000", "xresolution is 1000000",
               ErrorKind::limit);
}

TEST_F(PbrtFile, IncludesThatNeverEndAreRefused) {
  expect_error("Include \"a b.pbrt\"", "includes too much", ErrorKind::limit);
  for (int i = 0; i < 30; ++i) {
    write_all(folder_.file(fmt::format("{}.pbrt", i)),
              fmt::format("Include \"{}.pbrt\" Include \"{}.pbrt\"", i + 1, i + 1));
  }
  write_all(folder_.file("30.pbrt"), "");
  expect_error("Include \"0.pbrt\"", "includes too much", ErrorKind::limit);
}

/// Each cut of a file, and each byte of it changed, is read or refused with an Error.
TEST_F(PbrtFile, NoDamageGetsThrough) {
  const std::string whole = view + R"(
      LightSource "spot" "point3 from" [ 1 5 0 ] "rgb I" [ 1 1 1 ]
      Material "plastic" "float roughness" 0.1
      ObjectBegin "o" Rotate 20 0 1 0 )" +
                            triangle + R"( ObjectEnd
      ObjectInstance "o"
      Shape "curve" "point3 P" [ 0 0 0  0 1 0  1 2 0  0 3 0 ] "float width" 0.5)";
  const auto try_file = [&](const std::string& text) {
    try {
      load(text);
    } catch (const Error& error) {
      EXPECT_TRUE(error.kind() == ErrorKind::input || error.kind() == ErrorKind::limit);
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  };
  testing::internal::CaptureStderr();
  for (size_t length = 0; length < whole.size(); length += 3) try_file(whole.substr(0, length));
  for (size_t i = 0; i < whole.size(); ++i) {
    std::string changed = whole;
    changed[i] = "9\"]"[i % 3];
    try_file(changed);
  }
  testing::internal::GetCapturedStderr();
}

}  // namespace
}  // namespace relume
