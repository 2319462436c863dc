#include <gtest/gtest.h>

#include <cstring>

#include "core/scene/io/hair_file.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace relume {
namespace {

using test::TemporaryFolder;
using test::write_all;

/// Writes HAIR files byte by byte, right or wrong.
struct HairBytes {
  uint32_t strands = 2;
  uint32_t points = 5;
  uint32_t arrays = 2;
  uint32_t segments = 0;
  float thickness = 0.2f;
  std::string body;

  template <class T>
  void add(std::initializer_list<T> values) {
    for (const T value : values) {
      body.append(reinterpret_cast<const char*>(&value), sizeof(T));
    }
  }

  std::string bytes() const {
    std::string out(128, '\0');
    std::memcpy(out.data(), "HAIR", 4);
    std::memcpy(&out[4], &strands, 4);
    std::memcpy(&out[8], &points, 4);
    std::memcpy(&out[12], &arrays, 4);
    std::memcpy(&out[16], &segments, 4);
    std::memcpy(&out[20], &thickness, 4);
    return out + body;
  }
};

/// Two strands of 3 and 2 points with every array.
HairBytes full_file() {
  HairBytes file;
  file.arrays = 31;
  file.add<uint16_t>({2, 1});
  file.add<float>({0, 0, 0, 0, 1, 0, 0, 2, 0, 5, 0, 0, 5, 3, 0});
  file.add<float>({0.4f, 0.2f, 0, 0.6f, 0.6f});
  file.add<float>({0, 0, 0, 0, 0});
  file.add<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 2.5f});
  return file;
}

class HairFile : public testing::Test {
 protected:
  Curves load(const std::string& bytes) {
    write_all(folder_.file("a.hair"), bytes);
    return load_hair(folder_.file("a.hair"), options_);
  }

  void expect_error(const HairBytes& file, const std::string& part) {
    EXPECT_ERROR(load(file.bytes()), ErrorKind::input, part);
  }

  TemporaryFolder folder_;
  HairOptions options_;
};

TEST_F(HairFile, ReadsEveryArray) {
  options_.material = 7;
  const Curves curves = load(full_file().bytes());
  EXPECT_EQ(curves.offsets, (std::vector<uint32_t>{0, 3, 5}));
  EXPECT_EQ(curves.materials, (std::vector<uint32_t>{7, 7}));
  ASSERT_EQ(curves.points.size(), 5u);
  EXPECT_EQ(curves.points[1], vec4(0, 1, 0, 0.1f));  // thickness is the diameter
  EXPECT_FLOAT_EQ(curves.points[2].w, 0.002f);       // a tip of 0 is raised to 1 % of the largest
  ASSERT_EQ(curves.colors.size(), 2u);
  EXPECT_LT(glm::distance(curves.colors[0], vec3(1.0f / 3.0f)), 1e-6f);
  EXPECT_EQ(curves.colors[1], vec3(0.5f, 0.5f, 1));  // mean 1.5 is clamped
}

TEST_F(HairFile, UsesTheDefaultsOfTheHeader) {
  HairBytes file;
  file.strands = 2;
  file.points = 4;
  file.segments = 1;
  file.add<float>({0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0});
  options_.thickness_scale = 3;
  const Curves curves = load(file.bytes());
  EXPECT_EQ(curves.offsets, (std::vector<uint32_t>{0, 2, 4}));
  EXPECT_FLOAT_EQ(curves.points[0].w, 0.3f);
  EXPECT_TRUE(curves.colors.empty());
}

TEST_F(HairFile, EveryTruncationAndEveryExtensionIsAnError) {
  const std::string bytes = full_file().bytes();
  for (size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_ERROR(load(bytes.substr(0, length)), ErrorKind::input,
                 "a.hair: byte " + std::to_string(length));
  }
  EXPECT_ERROR(load(bytes + "x"), ErrorKind::input, "its counts are wrong");
}

TEST_F(HairFile, RejectsWrongHeaders) {
  HairBytes file = full_file();
  file.strands = 0;
  expect_error(file, "holds no strands");
  file = full_file();
  file.points = 4;
  expect_error(file, "2 strands and 4 points make");
  file = full_file();
  file.arrays = 1 + 4;
  expect_error(file, "has no points array");
  file.arrays = 2 + 64;
  expect_error(file, "unknown arrays");
  file = full_file();
  file.strands = 11'000'000;
  EXPECT_ERROR(load(file.bytes()), ErrorKind::limit, "11000000 strands");
  file.strands = 9'000'000;  // would need far more bytes than there are
  expect_error(file, "cut short");
  std::string bytes = full_file().bytes();
  bytes[0] = 'B';
  EXPECT_ERROR(load(bytes), ErrorKind::input, "does not start with");
}

TEST_F(HairFile, RejectsStrandsThatDoNotAddUp) {
  HairBytes file = full_file();
  const uint16_t three = 3;
  std::memcpy(file.body.data(), &three, 2);
  expect_error(file, "its strands have 6 points together, the header says 5");
}

TEST_F(HairFile, NamesTheByteOfEveryBadNumber) {
  const auto with_float = [](size_t byte, float value) {
    HairBytes file = full_file();
    std::memcpy(&file.body[byte - 128], &value, 4);
    return file;
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  expect_error(with_float(132 + 12, nan), "byte 144: point 1 is not finite");
  expect_error(with_float(132, 2e9f), "byte 132: point 0 is not finite or above 1e9");
  expect_error(with_float(192, -1), "byte 192: point 0 has thickness -1");
  expect_error(with_float(192 + 4, nan), "point 1 has thickness nan");
  expect_error(with_float(232, nan), "the colour of point 0 is not finite");
  HairBytes file;
  file.thickness = 0;
  expect_error(file, "byte 20: the default thickness");
}

TEST_F(HairFile, DropsSegmentsAndStrandsOfNoLength) {
  HairBytes file;
  file.arrays = 3;
  file.strands = 3;
  file.points = 7;
  file.add<uint16_t>({2, 1, 1});
  file.add<float>({0, 0, 0, 0, 0, 0, 0, 2, 0});  // a doubled point
  file.add<float>({1, 1, 1, 1, 1, 1});           // no length at all
  file.add<float>({5, 0, 0, 5, 3, 0});
  const Curves curves = load(file.bytes());
  EXPECT_EQ(curves.offsets, (std::vector<uint32_t>{0, 2, 4}));
  EXPECT_EQ(curves.materials.size(), 2u);
  HairBytes empty;
  empty.strands = 1;
  empty.points = 1;
  empty.add<float>({1, 2, 3});
  expect_error(empty, "holds no strand of two points");
}

}  // namespace
}  // namespace relume
