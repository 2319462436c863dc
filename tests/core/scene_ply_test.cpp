#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>

#include "core/scene/io/load_scene.h"
#include "core/scene/io/ply_file.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace relume {
namespace {

using test::TemporaryFolder;
using test::write_all;

const std::string ascii_header = R"(ply
format ascii 1.0
comment a quad, with more than is read
element vertex 4
property float x
property float y
property double z
property float nx
property float ny
property float nz
property uchar red
property float s
property float t
element face 1
property list uchar int vertex_indices
property int flags
element edge 1
property list ushort float lengths
end_header
)";
const std::string ascii_body =
    "0 0 0 0 0 2 255 0 0\n1 0 0 0 0 2 255 1 0\n1 1 0 0 0 2 255 1 1\n0 1 .5 0 0 2 255 0 1\n"
    "4 0 1 2 3 7\n3 1 2 3\n";

/// A triangle with one more vertex property and face property than is read.
std::string binary_triangle(bool is_big) {
  std::string bytes = fmt::format(
      "ply\nformat binary_{}_endian 1.0\nelement vertex 3\nproperty double x\nproperty float y\n"
      "property short z\nproperty uchar red\nelement face 1\nproperty list uint ushort "
      "vertex_index\nend_header\n",
      is_big ? "big" : "little");
  const auto append = [&](auto value) {
    char raw[sizeof(value)];
    std::memcpy(raw, &value, sizeof(value));
    if (is_big) std::reverse(raw, raw + sizeof(value));
    bytes.append(raw, sizeof(value));
  };
  for (int i = 0; i < 3; ++i) {
    append(static_cast<double>(i == 1 ? 2.5 : 0));
    append(static_cast<float>(i == 2 ? 1 : 0));
    append(static_cast<int16_t>(-3));
    append(static_cast<uint8_t>(200));
  }
  append(uint32_t{3});
  for (const int i : {0, 1, 2}) append(static_cast<uint16_t>(i));
  return bytes;
}

class PlyFile : public testing::Test {
 protected:
  IndexedMesh read(const std::string& bytes) {
    write_all(folder_.file("a b.ply"), bytes);
    return read_ply(folder_.file("a b.ply"));
  }
  void expect_error(const std::string& bytes, const std::string& part) {
    SCOPED_TRACE(bytes);
    EXPECT_ERROR(read(bytes), ErrorKind::input, part);
  }
  static std::string replaced(std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  }

  TemporaryFolder folder_;
};

TEST_F(PlyFile, TextComesAsItStands) {
  const IndexedMesh mesh = read(ascii_header + ascii_body);
  ASSERT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.positions[3], vec3(0, 1, 0.5f));
  EXPECT_EQ(mesh.normals.at(2), vec3(0, 0, 2));
  EXPECT_EQ(mesh.uvs.at(1), vec2(1, 0));
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.triangles[1], uvec3(0, 2, 3));
}

TEST_F(PlyFile, BothByteOrdersSayTheSame) {
  for (const bool is_big : {false, true}) {
    const IndexedMesh mesh = read(binary_triangle(is_big));
    ASSERT_EQ(mesh.positions.size(), 3u);
    EXPECT_EQ(mesh.positions[1], vec3(2.5f, 0, -3));
    EXPECT_EQ(mesh.positions[2], vec3(0, 1, -3));
    EXPECT_TRUE(mesh.normals.empty());
    ASSERT_EQ(mesh.triangles.size(), 1u);
    EXPECT_EQ(mesh.triangles[0], uvec3(0, 1, 2));
  }
}

TEST_F(PlyFile, StandsInSceneFiles) {
  write_all(folder_.file("quad.ply"), ascii_header + ascii_body);
  const std::string text = R"({"camera": {"fit": true}, "lights": [], "materials": [
      {"name": "clay", "shader": "lambert"}], "geometry": [
      {"file": "quad.ply", "material": "clay"}]})";
  const Scene scene = parse_scene(text, folder_.file("scene.json"), shader_table());
  ASSERT_EQ(count_scene(scene).triangles, 2u);
  EXPECT_EQ(scene.prototypes.at(0).name, "quad");
}

TEST_F(PlyFile, MistakesAreNamed) {
  const std::string whole = ascii_header + ascii_body;
  expect_error("obj\n", "does not start with \"ply\"");
  expect_error(replaced(whole, "end_header", "end_of"), "\"end_of\"");
  expect_error(replaced(whole, "ascii", "utf8"), "unknown format");
  expect_error(replaced(whole, "format ascii 1.0\n", ""), "names no format");
  expect_error(replaced(whole, "property uchar red", "property colour red"), "unknown type");
  expect_error(replaced(whole, "element vertex 4", "element vertex 4000000000"),
               "says it has 4000000000 of element vertex");
  expect_error(replaced(whole, "element vertex 4", "element vertex -4"), "a count is no number");
  expect_error(replaced(whole, "4 0 1 2 3 7", "4 0 1 2 9 7"), "refers to vertex 9 of 4");
  expect_error(replaced(whole, "4 0 1 2 3 7", "4 0 1 2 -1 7"), "face 0: refers to vertex -1");
  expect_error(replaced(whole, "4 0 1 2 3 7", "2000 0 1 2 3 7"), "a list of 2000 numbers");
  expect_error(replaced(whole, "1 1 0 0 0 2", "1 inf 0 0 0 2"), "vertex 2: is not finite");
  expect_error(replaced(whole, "1 1 0 0 0 2", "1 x 0 0 0 2"), "vertex 2: has no number");
  expect_error(replaced(whole, "property double z\n", ""), "vertex 0: has no position");
  EXPECT_ERROR(read_ply(folder_.file("gone.ply")), ErrorKind::input, "gone.ply");
}

/// Each cut of a file, and each byte of it changed, is read or refused with an Error.
TEST_F(PlyFile, NoDamageGetsThrough) {
  const auto try_file = [&](const std::string& bytes) {
    try {
      read(bytes);
      return 0;
    } catch (const Error& error) {
      EXPECT_TRUE(error.kind() == ErrorKind::input || error.kind() == ErrorKind::limit);
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      return 1;
    }
  };
  for (const std::string& whole : {ascii_header + ascii_body, binary_triangle(false)}) {
    int refused = 0;
    for (size_t length = 0; length + 3 < whole.size(); length += 2) {
      refused += try_file(whole.substr(0, length));
    }
    EXPECT_EQ(refused, static_cast<int>(whole.size() - 2) / 2);
    for (size_t i = 0; i < whole.size(); i += 2) {
      std::string changed = whole;
      changed[i] = static_cast<char>(changed[i] ^ (i % 4 == 0 ? 0x80 : 0x05));
      refused += try_file(changed);
    }
    EXPECT_GT(refused, static_cast<int>(whole.size()) / 2);
  }
}

}  // namespace
}  // namespace relume
