#include <gtest/gtest.h>
#include <zlib.h>

#include "core/scene/io/load_scene.h"
#include "core/scene/io/packed_file.h"
#include "core/scene/io/ply_file.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace relume {
namespace {

using test::read_all;
using test::TemporaryFolder;
using test::write_all;

const std::string triangle =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

class PackedFileTest : public testing::Test {
 protected:
  std::filesystem::path pack(const std::string& name, const std::string& text) {
    const std::filesystem::path path = folder_.file(name);
    const gzFile file = gzopen(path.c_str(), "wb");
    EXPECT_EQ(gzwrite(file, text.data(), static_cast<unsigned>(text.size())),
              static_cast<int>(text.size()));
    gzclose(file);
    return path;
  }

  TemporaryFolder folder_;
};

TEST_F(PackedFileTest, IsUnpackedByItsName) {
  std::string text;
  for (int i = 0; i < 400'000; ++i) text += std::to_string(i) + ' ';
  EXPECT_EQ(PackedFile(pack("a.gz", text)).text(), text);
  write_all(folder_.file("a.txt"), text);
  EXPECT_EQ(PackedFile(folder_.file("a.txt")).text(), text);
  EXPECT_EQ(PackedFile(pack("empty.gz", "")).text(), "");
}

TEST_F(PackedFileTest, PartsFollowEachOther) {
  const std::string parts = read_all(pack("a.gz", "one ")) + read_all(pack("b.gz", "two"));
  write_all(folder_.file("both.gz"), parts);
  EXPECT_EQ(PackedFile(folder_.file("both.gz")).text(), "one two");
}

TEST_F(PackedFileTest, DamageIsTold) {
  const std::string whole = read_all(pack("a.gz", triangle));
  for (size_t size = 0; size < whole.size(); ++size) {
    write_all(folder_.file("cut.gz"), whole.substr(0, size));
    EXPECT_ERROR(PackedFile(folder_.file("cut.gz")), ErrorKind::input, "cut.gz");
  }
  write_all(folder_.file("none.gz"), triangle);
  EXPECT_ERROR(PackedFile(folder_.file("none.gz")), ErrorKind::input, "no whole gzip file");
  write_all(folder_.file("more.gz"), whole + "rest");
  EXPECT_ERROR(PackedFile(folder_.file("more.gz")), ErrorKind::input, "no whole gzip file");
}

TEST_F(PackedFileTest, WhatUnpacksToTooMuchIsRefused) {
  const std::string zeros(least_unpacked_limit + 1, '\0');
  EXPECT_ERROR(PackedFile(pack("bomb.gz", zeros)), ErrorKind::limit, "unpacks to more than");
}

TEST_F(PackedFileTest, ShortFilesMayUnpackToManyTimesTheirSize) {
  const std::string zeros(size_t{2} << 20, '\0');
  const std::filesystem::path path = pack("zeros.gz", zeros);
  ASSERT_GT(zeros.size(), most_unpacked_times * std::filesystem::file_size(path));
  EXPECT_EQ(PackedFile(path).text().size(), zeros.size());
}

TEST_F(PackedFileTest, ScenesIncludeThem) {
  EXPECT_EQ(read_ply(pack("a.ply.gz", triangle)).positions.size(), 3u);
  pack("part.pbrt.gz", "Shape \"plymesh\" \"string filename\" \"a.ply.gz\"\n");
  const std::filesystem::path scene =
      pack("scene.pbrt.gz", "WorldBegin\nInclude \"part.pbrt.gz\"\n");
  EXPECT_EQ(load_scene(scene.string(), shader_table()).prototypes.size(), 1u);
}

}  // namespace
}  // namespace relume
