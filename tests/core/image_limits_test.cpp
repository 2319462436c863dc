#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "core/image/deep_io.h"
#include "core/image/exr_header.h"
#include "core/image/image_io.h"
#include "core/scene/io/texture_file.h"
#include "tests/support/color_config_file.h"

// Where the readers of images end what they take, and what they fill in.

namespace relume {
namespace {

template <class Value>
void append(std::string& bytes, const Value& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

void append_attribute(std::string& bytes, const std::string& name, const std::string& type,
                      const std::string& value) {
  bytes += name + '\0' + type + '\0';
  append(bytes, static_cast<int32_t>(value.size()));
  bytes += value;
}

/// An EXR of one pixel up to its only offset; one channel, one attribute more.
std::string exr_header(const std::string& channel, const std::string& attribute) {
  std::string bytes;
  append(bytes, uint32_t{20000630});
  append(bytes, uint32_t{2});
  append_attribute(bytes, "dataWindow", "box2i", std::string(16, '\0'));
  append_attribute(bytes, "channels", "chlist", channel + '\0' + std::string(16, '\0') + '\0');
  append_attribute(bytes, attribute, "string", "text");
  return bytes + '\0' + std::string(8, '\0');
}

std::string fault_of(const std::string& bytes) {
  const auto fault = find_exr_fault(std::as_bytes(std::span(bytes)), 16384);
  return fault ? fault->what : "";
}

TEST(ExrHeader, NamesMayBeAsLongAsTheFormatAllows) {
  const std::string longest(255, 'n');
  EXPECT_EQ(fault_of(exr_header("R", "comment")), "");
  EXPECT_EQ(fault_of(exr_header(longest, longest)), "");
  EXPECT_NE(fault_of(exr_header("R", longest + 'n')).find("a name in it too long"),
            std::string::npos);
  EXPECT_NE(fault_of(exr_header(longest + 'n', "comment")).find("list of channels"),
            std::string::npos);
}

TEST(ExrHeader, EveryOffsetOfTheTableIsThere) {
  const std::string whole = exr_header("R", "comment");
  EXPECT_EQ(fault_of(whole), "");
  for (size_t cut = 1; cut < whole.size() - 8; ++cut) {
    EXPECT_NE(fault_of(whole.substr(0, whole.size() - cut)), "") << cut;
  }
}

TEST(DeepImageDefault, IsEmpty) {
  const DeepImage image;
  EXPECT_EQ(image.width, 0);
  EXPECT_EQ(image.height, 0);
  EXPECT_EQ(image.pixel_count(), 0u);
}

TEST(ChannelRows, HoldEveryPixel) {
  const test::TemporaryFolder folder;
  Image image(5, 3, 2);
  for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = static_cast<float>(i + 1);
  const std::filesystem::path path = folder.file("a.exr");
  write_exr(path, std::array<ExrLayer, 1>{{{"", {"P.x", "P.y"}, &image}}});
  std::vector<float> found;
  read_channel_rows(path, std::vector<std::string>{"P.x", "P.y"},
                    [&](int y, std::span<const float> values) {
                      EXPECT_EQ(found.size(), static_cast<size_t>(10 * y));
                      found.insert(found.end(), values.begin(), values.end());
                    });
  EXPECT_EQ(found, image.pixels);
}

TEST(TextureAlpha, IsTheFilesOrOneInEveryColourSpace) {
  const test::ColorConfigFile config;
  const auto alpha_of = [&](const std::vector<std::string>& names, const std::string& space) {
    Image image(2, 1, static_cast<int>(names.size()));
    for (int x = 0; x < 2; ++x) {
      if (image.channels == 4) image.at(x, 0)[3] = x == 0 ? 0.2f : 0.8f;
    }
    const std::filesystem::path path = config.folder().file("alpha.exr");
    write_exr(path, std::array<ExrLayer, 1>{{{"", names, &image}}});
    Scene scene;
    const int texture = add_texture(scene, path, true, "test", space);
    const std::vector<uint8_t>& texels = scene.textures.at(static_cast<size_t>(texture)).texels;
    return std::pair<int, int>(texels.at(3), texels.at(7));
  };
  for (const char* space : {"", "shown"}) {
    EXPECT_EQ(alpha_of({"R", "G", "B", "A"}, space), std::pair(51, 204)) << space;
    EXPECT_EQ(alpha_of({"R", "G", "B"}, space), std::pair(255, 255)) << space;
  }
}

}  // namespace
}  // namespace relume
