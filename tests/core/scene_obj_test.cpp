#include <gtest/gtest.h>

#include "core/base/check.h"
#include "core/image/image_io.h"
#include "core/scene/io/obj.h"
#include "core/scene/io/smooth_normals.h"
#include "core/shade/phong.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace relume {
namespace {

using test::TemporaryFolder;
using test::write_all;

const std::string quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

class ObjFile : public testing::Test {
 protected:
  ObjFile() { scene_.shaders.assign(shader_table().begin(), shader_table().end()); }

  Mesh load(const std::string& text, const std::string& name = "a b.obj") {
    write_all(folder_.file(name), text);
    scene_.materials.clear();
    scene_.textures.clear();
    return load_obj(folder_.file(name), options_, scene_);
  }

  void expect_error(const std::string& text, const std::string& part) {
    SCOPED_TRACE(text);
    EXPECT_ERROR(load(text), ErrorKind::input, part);
  }

  void write_texture(const std::string& name, uint8_t alpha, uint8_t grey = 128) {
    DisplayImage image;
    image.width = 2;
    image.height = 2;
    image.channels = 4;
    image.pixels.assign(16, grey);
    for (size_t i = 3; i < 16; i += 4) image.pixels[i] = alpha;
    write_png(folder_.file(name), image);
  }

  std::string_view shader_name(const Material& material) const {
    return scene_.shaders[material.shader]->name;
  }
  const vec3* parameter(const Material& material, const std::string& name) {
    for (const MaterialParameter& p : material.parameters) {
      if (p.name == name) return &p.value;
    }
    return nullptr;
  }

  TemporaryFolder folder_;
  Scene scene_;
  ObjOptions options_;
};

double area_of(const Mesh& mesh) {
  double area = 0;
  for (const uvec3 t : mesh.triangles) {
    const dvec3 a(mesh.positions[t.x]);
    area += 0.5 *
            glm::length(glm::cross(dvec3(mesh.positions[t.y]) - a, dvec3(mesh.positions[t.z]) - a));
  }
  return area;
}

TEST_F(ObjFile, ReadsAQuadAsTwoTrianglesWithANormal) {
  const Mesh mesh = load(quad + "f 1 2 3 4\n");
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_TRUE(mesh.uvs.empty());
  ASSERT_EQ(mesh.normals.size(), 4u);
  for (const vec3 n : mesh.normals) EXPECT_EQ(n, vec3(0, 0, 1));
  ASSERT_EQ(scene_.materials.size(), 1u);
}

TEST_F(ObjFile, AcceptsWhatExportersWrite) {
  const size_t two = 2;
  EXPECT_EQ(
      load("\r\n# c\r\nv 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\nf 1 2 3 4\r\n").triangles.size(),
      two);
  EXPECT_EQ(load(quad + "f -4 -3 -2 -1\n").triangles.size(), two);
  EXPECT_EQ(load(quad + "f 1 2 3 4 # a face\n").triangles.size(), two);
  EXPECT_EQ(load(quad + "l 1 2\np 1\ng x y\ns off\no z\nf 1 2 3 4").triangles.size(), two);
  EXPECT_EQ(load("\tv\t0 0 0 1 0.5 0.5 \nv 1. .0 -0e3\nv +1 1 0\nv 0 1e0 0\nf 1 2 3 4\n")
                .triangles.size(),
            two);
  EXPECT_EQ(load("f 1 2 3 4\n" + quad).triangles.size(), two);
  EXPECT_EQ(load(quad + "vt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n").uvs.size(), 3u);
}

TEST(SmoothNormals, OfFacesThatCancelAreThoseOfOne) {
  // Four wings around the z axis.
  const std::vector<vec3> positions = {{0, 0, 0}, {0, 0, 1},  {1, 0, 0},
                                       {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  const std::vector<uvec3> wings = {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}, {0, 1, 5}};
  const SmoothNormals smooth = make_smooth_normals(positions, wings, 180);
  const std::vector<vec3> faces = {{0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {1, 0, 0}};
  for (size_t corner = 0; corner < 12; ++corner) {
    const vec3 normal = smooth.normals.at(smooth.normal_of_corner.at(corner));
    if (corner % 3 == 2) {
      EXPECT_EQ(normal, faces[corner / 3]) << corner;
    } else {
      EXPECT_EQ(normal, smooth.normals[smooth.normal_of_corner[corner % 3]]) << corner;
      EXPECT_NE(std::ranges::find(faces, normal), faces.end()) << corner;
    }
  }
}

TEST_F(ObjFile, CutsConcavePolygonsInside) {
  // A comb: the fan of any corner would leave the polygon.
  const Mesh mesh = load(
      "v 0 0 0\nv 7 0 0\nv 7 3 0\nv 6 3 0\nv 6 1 0\nv 4 1 0\nv 4 3 0\nv 3 3 0\nv 3 1 0\nv 1 1 0\n"
      "v 1 3 0\nv 0 3 0\nf 1 2 3 4 5 6 7 8 9 10 11 12\n");
  EXPECT_EQ(mesh.triangles.size(), 10u);
  EXPECT_NEAR(area_of(mesh), 7 + 3 * 2, 1e-9);
  // The concave quad has only one diagonal inside.
  EXPECT_NEAR(area_of(load("v 0 0 0\nv 2 1 0\nv 0 2 0\nv 0.5 1 0\nf 1 2 3 4\n")), 1.5, 1e-9);
  EXPECT_NEAR(area_of(load("v 0 0 0\nv 2 1 0\nv 0 2 0\nv 0.5 1 0\nf 4 1 2 3\n")), 1.5, 1e-9);
}

TEST_F(ObjFile, DropsTrianglesWithoutAreaAndCountsThem) {
  const auto count = [] {
    const std::string text = rare_events();
    const size_t at = text.find("OBJ triangles without area dropped: ");
    return at == std::string::npos ? 0 : std::stoi(text.substr(at + 36));
  };
  const int before = count();
  const Mesh mesh = load(quad + "v 2 0 0\nf 1 2 3\nf 1 2 5\nf 1 2 2\n");
  EXPECT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(count() - before, 2);
  expect_error(quad + "f 1 1 1\n", "holds no visible triangle");
}

TEST_F(ObjFile, SmoothsByAngle) {
  // Two quads that meet at the edge x = 0 and bend by 2 * atan(slope).
  const auto bent = [&](const std::string& slope) {
    return load("v -1 0 0\nv 0 " + slope + " 0\nv 1 0 0\nv -1 0 1\nv 0 " + slope +
                " 1\nv 1 0 1\nf 1 4 5 2\nf 2 5 6 3\n");
  };
  const Mesh smooth = bent("0.1");  // 11.4 degrees
  EXPECT_EQ(smooth.positions.size(), 6u);
  int upright = 0;
  for (const vec3 n : smooth.normals) upright += n.y > 0.9999f ? 1 : 0;
  EXPECT_EQ(upright, 2);
  EXPECT_EQ(bent("1").positions.size(), 8u);  // 90 degrees
  options_.smooth_angle_deg = 100;
  EXPECT_EQ(bent("1").positions.size(), 6u);
}

TEST_F(ObjFile, WeighsNormalsByAngleNotByTriangles) {
  // A cube's corner: three right angles, one of them cut into two triangles.
  options_.smooth_angle_deg = 180;
  const Mesh mesh =
      load("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 0\nf 1 3 5\nf 1 5 2\nf 1 4 3\nf 1 2 4\n");
  const float expected = -1 / std::sqrt(3.0f);
  int found = 0;
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    if (mesh.positions[i] != vec3(0)) continue;
    EXPECT_LT(glm::distance(mesh.normals[i], vec3(expected)), 1e-5f);
    ++found;
  }
  EXPECT_EQ(found, 1);
}

TEST_F(ObjFile, KeepsTheFilesNormalsAndReplacesZeroOnes) {
  const Mesh mesh = load(quad + "vn 0 3 4\nvn 0 0 0\nf 1//1 2//1 3//2\n");
  ASSERT_EQ(mesh.normals.size(), 3u);
  EXPECT_LT(glm::distance(mesh.normals[0], vec3(0, 0.6f, 0.8f)), 1e-6f);
  EXPECT_EQ(mesh.normals[2], vec3(0, 0, 1));
}

TEST_F(ObjFile, NamesTheLineOfEveryDefect) {
  expect_error("v 0 0 0\nv 1 x 0\nf 1 2 3\n", "a b.obj:2: \"x\" is not a number");
  expect_error("v 0 0 0\nv 1 nan 0\nf 1 2 3\n", "a b.obj:2: nan is not finite");
  expect_error("v 0 0 0\nv 1 1e39 0\nf 1 2 3\n", "a b.obj:2: 1e39 is not finite or too large");
  expect_error("v 0 0 -inf\n", "a b.obj:1:");
  expect_error(quad + "vn 1 0\nf 1 2 3\n", "a b.obj:5: 2 numbers");
  expect_error(quad + "f 1 2\n", "a b.obj:5: a face of 2 corners");
  expect_error(quad + "f 1 2 5\nf 1 2 3\n", "a b.obj:5: refers to vertex 5 of 4");
  expect_error(quad + "f 1 2 -5\n", "a b.obj:5: index -5 points before the first of 4");
  expect_error(quad + "f 1 2 0\n", "a b.obj:5: \"0\" is not a face corner");
  expect_error(quad + "f 1 2 99999999999999999999\n", "is not a face corner");
  expect_error(quad + "f 1 2 2000000000\n", "a b.obj:5: index 2000000000 is beyond");
  expect_error(quad + "f 1/1 2/1 3/1\n", "refers to texture coordinate 1 of 0");
  expect_error(quad + "f 1//1 2//1 3//1\n", "refers to normal 1 of 0");
  expect_error(quad + "f 1/ 2/ 3/\n", "is not a face corner");
  expect_error(quad + "vt 0 0\nf 1/1 2/1 3\n", "has other parts");
  expect_error(quad + "f 1 2 \\\n3\n", "a b.obj:5: continues on the next line");
  expect_error("<html>\n", "a b.obj:1: \"<html>\" is no OBJ statement");
  expect_error(quad, "holds no faces");
  expect_error("", "holds no faces");
  expect_error(std::string("v 0 0 0\0\n", 9), "zero bytes");
}

TEST_F(ObjFile, EveryCutInsideALineIsOneErrorUnlessNothingIsMissing) {
  std::string text;
  for (int i = 0; i < 12; ++i)
    text += "v " + std::to_string(i) + " " + std::to_string(i * i) + " 0\n";
  for (int i = 1; i <= 10; ++i) {
    text +=
        "f " + std::to_string(i) + " " + std::to_string(i + 1) + " " + std::to_string(i + 2) + "\n";
  }
  for (size_t length = 1; length + 1 < text.size(); ++length) {
    const bool at_line_end = text[length - 1] == '\n' || text[length] == '\n';
    if (at_line_end && text.find('f') < length) continue;  // a shorter, well-formed file
    SCOPED_TRACE(text.substr(0, length));
    EXPECT_ERROR(load(text.substr(0, length)), ErrorKind::input, "a b.obj");
  }
}

TEST_F(ObjFile, ReadsMaterialsWithSpacesInNames) {
  write_all(folder_.file("my materials.mtl"),
            "newmtl dull red\r\nKd 0.5 0.1 0.1\r\nKs 0 0 0\r\nNs 10\r\n"
            "newmtl shiny\nKd 2 0.5 -1\nKs 0.4 0.4 0.4\nNs 38\n");
  const Mesh mesh =
      load("mtllib my materials.mtl\n" + quad +
           "usemtl dull red\nf 1 2 3\nusemtl shiny\nf 1 3 4\nusemtl unknown\nf 2 3 4\n");
  ASSERT_EQ(scene_.materials.size(), 3u);
  EXPECT_EQ(mesh.materials, (std::vector<uint32_t>{0, 1, 2}));
  EXPECT_EQ(scene_.materials[0].name, "dull red");
  EXPECT_EQ(shader_name(scene_.materials[0]), "lambert");
  EXPECT_EQ(*parameter(scene_.materials[0], "diffuse"), vec3(0.5f, 0.1f, 0.1f));
  EXPECT_EQ(shader_name(scene_.materials[1]), "phong");
  EXPECT_EQ(*parameter(scene_.materials[1], "diffuse"), vec3(1, 0.5f, 0));
  EXPECT_EQ(shader_name(scene_.materials[2]), "lambert");
}

TEST_F(ObjFile, ReadsEmission) {
  write_all(folder_.file("a.mtl"), "newmtl m\nKd 0 0 0\nKe 2 0 0.5\nnewmtl n\nKd 1 1 1\n");
  load("mtllib a.mtl\n" + quad + "usemtl m\nf 1 2 3\nusemtl n\nf 1 3 4\n");
  EXPECT_EQ(scene_.materials.at(0).emission, vec3(2, 0, 0.5f));
  EXPECT_EQ(scene_.materials.at(1).emission, vec3(0));
  write_all(folder_.file("a.mtl"), "newmtl m\nKe 2 0\n");
  expect_error("mtllib a.mtl\n" + quad + "usemtl m\nf 1 2 3\n", "a.mtl");
}

TEST_F(ObjFile, KeepsTheRatioOfPeakToDiffuseOfClassicPhong) {
  write_all(folder_.file("a.mtl"), "newmtl m\nKd 0.5 0.5 0.5\nKs 0.25 0.25 0.25\nNs 30\n");
  load("mtllib a.mtl\n" + quad + "usemtl m\nf 1 2 3\n");
  const Material& material = scene_.materials.at(0);
  const double specular = parameter(material, "specular")->x;
  const double exponent = parameter(material, "exponent")->x;
  const auto radiance = [&](double kd, double ks) {
    const std::array<double, 14> v{0, 0, 0, 0, 0, 0, 1, kd, kd, kd, ks, ks, ks, exponent};
    return Phong::reference(v.data(), dvec3(0, 0, 1), dvec3(0, 0, 1)).x;
  };
  const double diffuse_only = radiance(0.5, 0);
  EXPECT_NEAR((radiance(0.5, specular) - diffuse_only) / diffuse_only, 0.25 / 0.5, 1e-6);
}

TEST_F(ObjFile, MakesLeavesOfTheListedMaterials) {
  write_all(folder_.file("a.mtl"), "newmtl leaf\nKd 0.2 0.6 0.1\nKs 1 1 1\nNs 30\n");
  options_.leaf_materials = {"leaf"};
  options_.leaf_transmission = 0.5f;
  load("mtllib a.mtl\n" + quad + "usemtl leaf\nf 1 2 3\n");
  EXPECT_EQ(shader_name(scene_.materials.at(0)), "leaf");
  EXPECT_EQ(*parameter(scene_.materials[0], "transmit"), vec3(0.1f, 0.3f, 0.05f));
  options_.leaf_materials = {"laef"};
  expect_error("mtllib a.mtl\n" + quad + "usemtl leaf\nf 1 2 3\n", "the file uses: \"leaf\"");
}

TEST_F(ObjFile, ReadsTexturesAndCutOuts) {
  std::filesystem::create_directories(folder_.file("tex dir"));
  write_texture("tex dir/solid.png", 255);
  write_texture("tex dir/holes.png", 0);
  write_all(folder_.file("a.mtl"),
            "newmtl solid\nKd 1 1 1\nmap_Kd tex dir\\solid.png\n"
            "newmtl cut\nKd 1 1 1\nmap_Kd tex dir/holes.png\n"
            "newmtl mask\nKd 1 1 1\nmap_d -s 1 1 1 tex dir/solid.png\n"
            "newmtl twice\nKd 1 1 1\nmap_Kd tex dir/solid.png\nmap_d tex dir/solid.png\n"
            "newmtl moved\nmap_Kd C:\\art\\moved.png\n");
  write_texture("moved.png", 255);
  std::string text = "mtllib a.mtl\n" + quad;
  for (const char* name : {"solid", "cut", "mask", "twice", "moved"}) {
    text += std::string("usemtl ") + name + "\nf 1 2 3\n";
  }
  load(text);
  ASSERT_EQ(scene_.materials.size(), 5u);
  EXPECT_GE(scene_.materials[0].parameters.at(0).texture, 0);
  EXPECT_EQ(scene_.materials[0].alpha_texture, -1);
  EXPECT_GE(scene_.materials[1].alpha_texture, 0);
  EXPECT_FALSE(scene_.materials[1].alpha_from_luminance);
  EXPECT_GE(scene_.materials[2].alpha_texture, 0);
  EXPECT_TRUE(scene_.materials[2].alpha_from_luminance);
  EXPECT_EQ(scene_.materials[3].alpha_texture, -1);
  EXPECT_GE(scene_.materials[4].parameters.at(0).texture, 0);
}

TEST_F(ObjFile, LeavesOutSeeThroughMaterials) {
  write_all(folder_.file("a.mtl"), "newmtl glass\nd 0.2\nnewmtl wall\nd 0.8\n");
  const Mesh mesh = load("mtllib a.mtl\n" + quad + "usemtl glass\nf 1 2 3\nusemtl wall\nf 1 3 4\n");
  EXPECT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(scene_.materials.size(), 1u);
}

TEST_F(ObjFile, NamesMaterialAndFileOfBadMtlContents) {
  const std::string text = "mtllib a.mtl\n" + quad + "usemtl m\nf 1 2 3\n";
  write_all(folder_.file("a.mtl"), "newmtl m\nKd 0.5 0.5\n");
  expect_error(text, "a.mtl:2: 2 numbers");
  write_all(folder_.file("a.mtl"), "newmtl m\nKd 0.5 0.5 nan\n");
  expect_error(text, "a.mtl:2: nan");
  write_all(folder_.file("a.mtl"), "newmtl\n");
  expect_error(text, "a.mtl:1: newmtl lacks a name");
  write_all(folder_.file("a.mtl"), "newmtl m\nmap_Kd no such.png\n");
  expect_error(text, "a.mtl: material \"m\": map_Kd");
  write_all(folder_.file("broken.png"), "not a png");
  write_all(folder_.file("a.mtl"), "newmtl m\nmap_Kd broken.png\n");
  expect_error(text, "a.mtl: material \"m\": map_Kd");
}

TEST_F(ObjFile, UsesGreyWhenTheMtlIsMissing) {
  load("mtllib gone.mtl\n" + quad + "usemtl m\nf 1 2 3\n");
  ASSERT_EQ(scene_.materials.size(), 1u);
  EXPECT_EQ(*parameter(scene_.materials[0], "diffuse"), vec3(0.5f));
}

TEST_F(ObjFile, OverridesAllMaterials) {
  options_.material_override = 3;
  const Mesh mesh = load("mtllib gone.mtl\n" + quad + "usemtl m\nf 1 2 3\nf 1 3 4\n");
  EXPECT_EQ(mesh.materials, (std::vector<uint32_t>{3, 3}));
  EXPECT_TRUE(scene_.materials.empty());
}

}  // namespace
}  // namespace relume
