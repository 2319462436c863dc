#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numeric>

#include "core/image/deep_io.h"
#include "core/image/exr_rows.h"
#include "core/image/image_io.h"
#include "tests/support/expect_error.h"
#include "tests/support/oiiotool.h"
#include "tests/support/temporary_folder.h"

namespace relume::test {
namespace {

constexpr int width = 37;
constexpr int height = 70;

/// A flat EXR of the channels a.V, b.V, c.V: at (x, y) they hold 1000 y + x, plus 0.25, plus 0.5.
class FlatRows : public testing::Test {
 protected:
  FlatRows() {
    Image image(width, height, 3);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        for (int c = 0; c < 3; ++c) image.at(x, y)[c] = expected(x, y, c);
      }
    }
    write_exr(file_, std::array<ExrLayer, 1>{{{"", {"a.V", "b.V", "c.V"}, &image}}});
  }

  static float expected(int x, int y, int c) {
    return 1000.0f * static_cast<float>(y) + static_cast<float>(x) + 0.25f * static_cast<float>(c);
  }

  /// c.V and a.V of rows [begin, end); pixels that are not `inside` are 0.
  template <class Inside>
  static void expect_rows(ExrRows& rows, int begin, int end, const Inside& inside) {
    const ExrRowValues read = rows.read(begin, end);
    ASSERT_EQ(read.values.size(), static_cast<size_t>(2 * width * (end - begin)));
    EXPECT_TRUE(read.counts.empty());
    const float* value = read.values.data();
    for (int y = begin; y < end; ++y) {
      for (int x = 0; x < width; ++x) {
        ASSERT_EQ(*value++, inside(x, y) ? expected(x, y, 2) : 0.0f) << x << ", " << y;
        ASSERT_EQ(*value++, inside(x, y) ? expected(x, y, 0) : 0.0f) << x << ", " << y;
      }
    }
  }

  /// The file changed by oiiotool; empty where there is none.
  std::filesystem::path changed(const std::string& options) const {
    const std::filesystem::path out = folder_.file("changed.exr");
    const bool ok = run_oiiotool(fmt::format("{} {} -o {}", file_.string(), options, out.string()));
    return ok ? out : std::filesystem::path();
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.file("flat.exr");
  std::vector<std::string> wanted_{"c.V", "a.V"};
};

const auto everywhere = [](int, int) { return true; };

TEST_F(FlatRows, GiveTheChosenChannelsInAnyOrder) {
  ExrRows rows(file_);
  EXPECT_EQ(rows.width(), width);
  EXPECT_EQ(rows.height(), height);
  EXPECT_FALSE(rows.is_deep());
  rows.choose(wanted_);
  for (const auto& [begin, end] :
       {std::pair(0, height), {40, 56}, {0, 16}, {69, 70}, {15, 33}, {20, 20}}) {
    expect_rows(rows, begin, end, everywhere);
  }
}

TEST_F(FlatRows, GiveTheSameOfTiles) {
  if (!has_oiiotool()) GTEST_SKIP() << "no oiiotool";
  ExrRows rows(changed("--tile 16 32"));
  rows.choose(wanted_);
  for (const auto& [begin, end] : {std::pair(0, height), {40, 56}, {31, 33}, {64, 70}}) {
    expect_rows(rows, begin, end, everywhere);
  }
}

TEST_F(FlatRows, AreBlackOutsideTheData) {
  if (!has_oiiotool()) GTEST_SKIP() << "no oiiotool";
  ExrRows rows(changed("--crop 20x30+5+10"));
  rows.choose(wanted_);
  const auto inside = [](int x, int y) { return x >= 5 && x < 25 && y >= 10 && y < 40; };
  for (const auto& [begin, end] : {std::pair(0, height), {8, 16}, {32, 48}, {50, 60}}) {
    expect_rows(rows, begin, end, inside);
  }
}

TEST_F(FlatRows, RefuseWhatIsNotThere) {
  ExrRows rows(file_);
  EXPECT_ERROR(rows.choose(std::vector<std::string>{"a.V", "d.V"}), ErrorKind::input,
               "no channel 'd.V'");
  EXPECT_ERROR(ExrRows(folder_.file("absent.exr")), ErrorKind::input, "no such file");
  write_all(folder_.file("text.exr"), "not an image");
  EXPECT_ERROR(ExrRows(folder_.file("text.exr")), ErrorKind::input, "is no OpenEXR file");
}

TEST_F(FlatRows, TellThatAFileEndsEarly) {
  const std::string whole = read_all(file_);
  write_all(file_, whole.substr(0, whole.size() / 2));
  const auto read_everything = [&] {
    ExrRows rows(file_);
    rows.choose(wanted_);
    rows.read(0, height);
  };
  EXPECT_ERROR(read_everything(), ErrorKind::input, "flat.exr");
}

TEST(DeepRows, AreThoseOfTheWholeImageInAnyOrder) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.file("deep.exr");
  DeepImage image{width, height, {{"A", false}, {"Z", false}}, {}, {}};
  for (size_t pixel = 0; pixel < image.pixel_count(); ++pixel) {
    image.counts.push_back(static_cast<uint32_t>(pixel * 7 % 5));
    for (uint32_t i = 0; i < 2 * image.counts.back(); ++i) {
      image.values.push_back(static_cast<float>(image.values.size()));
    }
  }
  write_deep_exr(file, image);
  ExrRows rows(file);
  EXPECT_TRUE(rows.is_deep());
  rows.choose(std::vector<std::string>{"A", "Z"});
  for (const auto& [begin, end] : {std::pair(48, height), {0, 16}, {16, 48}}) {
    const ExrRowValues read = rows.read(begin, end);
    const auto first = image.counts.begin() + begin * width;
    EXPECT_TRUE(std::equal(read.counts.begin(), read.counts.end(), first,
                           image.counts.begin() + end * width));
    const auto before = 2 * std::accumulate(image.counts.begin(), first, 0);
    EXPECT_TRUE(std::equal(read.values.begin(), read.values.end(), image.values.begin() + before));
    EXPECT_EQ(read.values.size(), 2 * std::accumulate(read.counts.begin(), read.counts.end(), 0u));
  }
}

}  // namespace
}  // namespace relume::test
