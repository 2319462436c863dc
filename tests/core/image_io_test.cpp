#include "core/image/image_io.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/random.h"
#include "core/base/timer.h"
#include "core/math/color.h"
#include "core/scene/io/texture_file.h"
#include "tests/support/temporary_folder.h"

namespace relume {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<uint8_t>;

class ImageIo : public testing::Test {
 protected:
  fs::path in_folder(const std::string& name) const { return folder_.file(name); }

 private:
  const test::TemporaryFolder folder_;
};

Image random_image(int width, int height, int channels, uint64_t seed) {
  Image image(width, height, channels);
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    Random random(seed, RandomStream::tests, i);
    const float mantissa = random.uniform(-1, 1);
    const float exponent = random.uniform(-20, 20);
    image.pixels[i] = mantissa * std::exp2(exponent);
  }
  return image;
}

Bytes read_bytes(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(file), {});
}

void write_bytes(const fs::path& path, const Bytes& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

/// Runs `action` and returns its Error, whose message must be one line.
template <class Action>
Error error_of(Action action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return error;
  }
  ADD_FAILURE() << "no Error was thrown";
  return Error(ErrorKind::usage, "none");
}

bool mentions(const Error& error, const std::string& text) {
  return std::string(error.what()).find(text) != std::string::npos;
}

// A PNG encoder of its own (stored deflate blocks), so that reading is not checked against the same
// library's writer, with the bit depths and colour types that write_png does not produce.

void append_big_endian(Bytes& out, uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<uint8_t>(value >> shift));
}

uint32_t crc32(const uint8_t* data, size_t size) {
  uint32_t crc = ~0u;
  for (size_t i = 0; i < size; ++i) {
    crc ^= data[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) ? 0xEDB88320u : 0u);
  }
  return ~crc;
}

void append_chunk(Bytes& out, const char* type, const Bytes& data) {
  append_big_endian(out, static_cast<uint32_t>(data.size()));
  const size_t start = out.size();
  out.insert(out.end(), type, type + 4);
  out.insert(out.end(), data.begin(), data.end());
  append_big_endian(out, crc32(&out[start], out.size() - start));
}

Bytes zlib_stored(const Bytes& raw) {
  Bytes out = {0x78, 0x01, 0x01};
  const auto size = static_cast<uint16_t>(raw.size());
  const auto complement = static_cast<uint16_t>(~size);
  for (const uint16_t value : {size, complement}) {
    out.push_back(static_cast<uint8_t>(value & 255));
    out.push_back(static_cast<uint8_t>(value >> 8));
  }
  out.insert(out.end(), raw.begin(), raw.end());
  uint32_t a = 1;
  uint32_t b = 0;
  for (const uint8_t byte : raw) {
    a = (a + byte) % 65521;
    b = (b + a) % 65521;
  }
  append_big_endian(out, (b << 16) | a);
  return out;
}

/// `rows` holds each row's bytes; colour types as in the PNG standard: 0 grey, 2 RGB, 4 grey +
/// alpha, 6 RGBA.
Bytes make_png(uint32_t width, uint32_t height, uint8_t depth, uint8_t color_type,
               const std::vector<Bytes>& rows) {
  Bytes header;
  append_big_endian(header, width);
  append_big_endian(header, height);
  header.insert(header.end(), {depth, color_type, 0, 0, 0});
  Bytes raw;
  for (const Bytes& row : rows) {
    raw.push_back(0);
    raw.insert(raw.end(), row.begin(), row.end());
  }
  Bytes out = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  append_chunk(out, "IHDR", header);
  append_chunk(out, "IDAT", zlib_stored(raw));
  append_chunk(out, "IEND", {});
  return out;
}

/// Replaces the data and display windows of an EXR.
void set_exr_window(Bytes& exr, int32_t width, int32_t height) {
  for (const std::string name : {"dataWindow", "displayWindow"}) {
    const std::string key = name + '\0' + "box2i" + '\0';
    const auto at = std::search(exr.begin(), exr.end(), key.begin(), key.end());
    ASSERT_NE(at, exr.end());
    const std::array<int32_t, 4> box = {0, 0, width - 1, height - 1};
    std::memcpy(&*at + key.size() + 4, box.data(), sizeof box);
  }
}

TEST_F(ImageIo, ExrKeepsEveryBitOfEveryLayer) {
  const Image beauty = random_image(37, 21, 3, 1);
  const Image key = random_image(37, 21, 3, 2);
  const Image depth = random_image(37, 21, 1, 3);
  const std::vector<ExrLayer> layers = {{"", {"R", "G", "B"}, &beauty},
                                        {"light.key.", {"R", "G", "B"}, &key},
                                        {"depth.", {"Z"}, &depth}};
  const fs::path path = in_folder("layers.exr");
  write_exr(path, layers, {{"relume:seed", "7"}});
  EXPECT_EQ(read_image(path).pixels, beauty.pixels);
  EXPECT_EQ(read_exr_layer(path, "light.key.").pixels, key.pixels);
  EXPECT_EQ(read_exr_layer(path, "").pixels, beauty.pixels);
  std::vector<std::string> names = read_channel_names(path);
  std::sort(names.begin(), names.end());
  const std::vector<std::string> expected = {"B",           "G",           "R",          "depth.Z",
                                             "light.key.B", "light.key.G", "light.key.R"};
  EXPECT_EQ(names, expected);
  const Bytes bytes = read_bytes(path);
  const std::string text(bytes.begin(), bytes.end());
  EXPECT_NE(text.find("relume:seed"), std::string::npos);
  EXPECT_EQ(std::distance(fs::directory_iterator(path.parent_path()), {}), 1)
      << "no temporary left";
}

TEST_F(ImageIo, ExrOfManyBandsKeepsRowOrder) {
  const Image tall = random_image(1500, 1100, 3, 4);
  const fs::path path = in_folder("tall.exr");
  write_exr(path, std::vector<ExrLayer>{{"", {"R", "G", "B"}, &tall}});
  const Image read = read_image(path);
  ASSERT_EQ(read.width, 1500);
  ASSERT_EQ(read.height, 1100);
  EXPECT_EQ(read.pixels, tall.pixels);
}

TEST_F(ImageIo, MissingLayerIsNamed) {
  const Image image = random_image(4, 4, 3, 5);
  const fs::path path = in_folder("one.exr");
  write_exr(path, std::vector<ExrLayer>{{"", {"R", "G", "B"}, &image}});
  const Error error = error_of([&] { read_exr_layer(path, "light.rim."); });
  EXPECT_EQ(error.kind(), ErrorKind::input);
  EXPECT_TRUE(mentions(error, "light.rim.R")) << error.what();
}

TEST_F(ImageIo, NonFiniteValueNamesItsPixel) {
  Image image = random_image(8, 6, 3, 6);
  image.at(5, 4)[1] = std::numeric_limits<float>::quiet_NaN();
  const fs::path path = in_folder("nan.exr");
  write_exr(path, std::vector<ExrLayer>{{"", {"R", "G", "B"}, &image}});
  for (const bool texture : {false, true}) {
    Scene scene;
    const Error error = error_of([&] {
      if (texture)
        add_texture(scene, path, true, "test");
      else
        read_image(path);
    });
    EXPECT_EQ(error.kind(), ErrorKind::input);
    EXPECT_TRUE(mentions(error, "(5, 4)")) << error.what();
  }
}

TEST_F(ImageIo, PngKeepsBytes) {
  for (const int channels : {3, 4}) {
    DisplayImage image{23, 11, channels, {}};
    for (size_t i = 0; i < size_t{23} * 11 * channels; ++i) {
      image.pixels.push_back(static_cast<uint8_t>(i * 37 + i / 7));
    }
    const fs::path path = in_folder("bytes.png");
    write_png(path, image);
    const Bytes bytes = read_bytes(path);
    ASSERT_GT(bytes.size(), 33u);
    EXPECT_EQ(std::memcmp(bytes.data(), "\x89PNG\r\n\x1a\n", 8), 0);
    EXPECT_EQ(bytes[19], 23) << "IHDR width";
    EXPECT_EQ(bytes[23], 11) << "IHDR height";
    EXPECT_EQ(bytes[24], 8) << "bit depth";
    EXPECT_EQ(bytes[25], channels == 3 ? 2 : 6) << "colour type";
    Scene scene;
    const int index = add_texture(scene, path, true, "test");
    const Texture& texture = scene.textures[static_cast<size_t>(index)];
    for (size_t i = 0; i < size_t{23} * 11; ++i) {
      for (int c = 0; c < 4; ++c) {
        const uint8_t expected = c < channels ? image.pixels[i * channels + c] : uint8_t{255};
        ASSERT_EQ(texture.texels[i * 4 + c], expected) << "pixel " << i << " channel " << c;
      }
    }
  }
}

TEST_F(ImageIo, EightBitFilesAreDecodedToLinear) {
  const fs::path path = in_folder("grey.png");
  write_bytes(path, make_png(4, 1, 8, 0, {{0, 10, 128, 255}}));
  const Image image = read_image(path);
  ASSERT_EQ(image.channels, 3);
  const std::array<int, 4> codes = {0, 10, 128, 255};
  for (int x = 0; x < 4; ++x) {
    const float expected = linear_from_srgb(static_cast<float>(codes[x]) / 255.0f);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(image.at(x, 0)[c], expected, 1e-6f) << x;
  }
}

TEST_F(ImageIo, TexturesBecomeRgbaOfEightBits) {
  const fs::path grey = in_folder("grey.png");
  write_bytes(grey, make_png(2, 1, 8, 0, {{7, 200}}));
  const fs::path grey_alpha = in_folder("grey_alpha.png");
  write_bytes(grey_alpha, make_png(2, 1, 8, 4, {{7, 0, 200, 100}}));
  const fs::path deep = in_folder("rgb16.png");
  write_bytes(deep, make_png(1, 1, 16, 2, {{0xFF, 0xFF, 0x80, 0x80, 0x00, 0x00}}));
  const fs::path rgba = in_folder("rgba.png");
  write_bytes(rgba, make_png(1, 1, 8, 6, {{200, 100, 50, 10}}));
  Scene scene;
  for (const fs::path& path : {grey, grey_alpha, deep, rgba})
    add_texture(scene, path, true, "test");
  EXPECT_EQ(scene.textures[0].texels, (Bytes{7, 7, 7, 255, 200, 200, 200, 255}));
  EXPECT_EQ(scene.textures[1].texels, (Bytes{7, 7, 7, 0, 200, 200, 200, 100}));
  EXPECT_EQ(scene.textures[2].texels, (Bytes{255, 128, 0, 255}));
  EXPECT_EQ(scene.textures[3].texels, (Bytes{200, 100, 50, 10})) << "colour not premultiplied";
}

TEST_F(ImageIo, LinearTexturesAreEncodedWhenTheyWillBeDecoded) {
  Image image(1, 1);
  image.pixels = {0.5f, 2.0f, -1.0f};
  const fs::path path = in_folder("linear.exr");
  write_exr(path, std::vector<ExrLayer>{{"", {"R", "G", "B"}, &image}});
  Scene scene;
  add_texture(scene, path, true, "test");
  add_texture(scene, path, false, "test");
  EXPECT_EQ(scene.textures[0].texels, (Bytes{188, 255, 0, 255}));
  EXPECT_EQ(scene.textures[1].texels, (Bytes{128, 255, 0, 255}));
}

TEST_F(ImageIo, TexturesAreSharedByPathAndCurve) {
  const fs::path path = in_folder("grey.png");
  write_bytes(path, make_png(1, 1, 8, 0, {{9}}));
  Scene scene;
  const int first = add_texture(scene, path, true, "test");
  const int same = add_texture(scene, path.parent_path() / "." / "grey.png", true, "test");
  const int data = add_texture(scene, path, false, "test");
  EXPECT_EQ(first, same);
  EXPECT_NE(first, data);
  EXPECT_EQ(scene.textures.size(), 2u);
}

TEST_F(ImageIo, MissingFileNamesItsPlace) {
  Scene scene;
  const Error error = error_of([&] { add_texture(scene, in_folder("none.png"), true, "a.mtl:7"); });
  EXPECT_EQ(error.kind(), ErrorKind::input);
  EXPECT_TRUE(mentions(error, "a.mtl:7") && mentions(error, "none.png")) << error.what();
  EXPECT_EQ(error_of([&] { read_image(in_folder("")); }).kind(), ErrorKind::input) << "a folder";
}

TEST_F(ImageIo, AnyTruncationOfAnExrIsOneError) {
  const Image image = random_image(64, 48, 3, 7);
  const fs::path path = in_folder("full.exr");
  write_exr(path, std::vector<ExrLayer>{{"", {"R", "G", "B"}, &image}});
  const Bytes full = read_bytes(path);
  const fs::path cut_path = in_folder("cut.exr");
  for (const double fraction : {0.0, 0.001, 0.01, 0.02, 0.1, 0.5, 0.9, 0.999}) {
    const auto size = static_cast<size_t>(fraction * static_cast<double>(full.size()));
    write_bytes(cut_path, Bytes(full.begin(), full.begin() + static_cast<std::ptrdiff_t>(size)));
    const Error error = error_of([&] { read_image(cut_path); });
    EXPECT_EQ(error.kind(), ErrorKind::input) << size << " bytes: " << error.what();
    EXPECT_TRUE(mentions(error, "cut.exr")) << error.what();
  }
}

TEST_F(ImageIo, TruncatedPngAndGarbageAreErrors) {
  DisplayImage image{64, 64, 3, Bytes(size_t{64} * 64 * 3)};
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    Random random(8, RandomStream::tests, i);
    image.pixels[i] = static_cast<uint8_t>(random.below(256));
  }
  const fs::path path = in_folder("full.png");
  write_png(path, image);
  const Bytes full = read_bytes(path);
  const fs::path bad = in_folder("bad.png");
  for (const size_t size : {size_t{0}, size_t{4}, size_t{20}, size_t{60}, full.size() / 2}) {
    write_bytes(bad, Bytes(full.begin(), full.begin() + static_cast<std::ptrdiff_t>(size)));
    EXPECT_EQ(error_of([&] { read_image(bad); }).kind(), ErrorKind::input) << size;
    Scene scene;
    EXPECT_EQ(error_of([&] { add_texture(scene, bad, true, "t"); }).kind(), ErrorKind::input);
    EXPECT_TRUE(scene.textures.empty());
  }
  write_bytes(bad, Bytes(3000, 0x5A));
  EXPECT_EQ(error_of([&] { read_image(bad); }).kind(), ErrorKind::input);
}

TEST_F(ImageIo, TruncatedJpegIsAnError) {
  const fs::path whole =
      fs::path(RELUME_SOURCE_DIR) / "../shared/scenes/sh3d_japaneseMaple/japaneseMapleTexture.jpg";
  if (!fs::exists(whole)) GTEST_SKIP() << "the shared scenes are not here";
  EXPECT_NO_THROW(read_image(whole));
  const Bytes full = read_bytes(whole);
  const fs::path cut = in_folder("cut.jpg");
  for (const size_t size : {full.size() / 20, full.size() / 2, full.size() - 100}) {
    write_bytes(cut, Bytes(full.begin(), full.begin() + static_cast<std::ptrdiff_t>(size)));
    EXPECT_EQ(error_of([&] { read_image(cut); }).kind(), ErrorKind::input) << size;
  }
}

TEST_F(ImageIo, HugeSizesFailBeforeAllocation) {
  const Image image = random_image(4, 4, 3, 9);
  const fs::path path = in_folder("huge.exr");
  write_exr(path, std::vector<ExrLayer>{{"", {"R", "G", "B"}, &image}});
  Bytes exr = read_bytes(path);
  set_exr_window(exr, 16385, 4);
  write_bytes(path, exr);
  EXPECT_EQ(error_of([&] { read_image(path); }).kind(), ErrorKind::limit);
  set_exr_window(exr, 16384, 16384);  // allowed, but the data is not there
  write_bytes(path, exr);
  const Timer timer;
  EXPECT_EQ(error_of([&] { read_image(path); }).kind(), ErrorKind::input);
  EXPECT_LT(timer.seconds(), 1) << "3 GiB were not touched";
  const fs::path png = in_folder("huge.png");
  write_bytes(png, make_png(20000, 1, 8, 0, {{1}}));
  EXPECT_EQ(error_of([&] { read_image(png); }).kind(), ErrorKind::limit);
}

TEST_F(ImageIo, ExrHeadersThatLieAreRefusedBeforeAnythingIsTaken) {
  const Image image = random_image(4, 4, 3, 9);
  const fs::path path = in_folder("lies.exr");
  write_exr(path, std::vector<ExrLayer>{{"", {"R", "G", "B"}, &image}});
  const Bytes exr = read_bytes(path);
  struct Lie {
    std::string key;  ///< attribute and type, each ended
    size_t at;        ///< from the attribute's size on
    uint32_t word;
    const char* said;
  };
  const Lie lies[] = {
      {std::string("channels\0chlist\0", 16), 0, 0x60000000, "bytes that are not there"},
      {std::string("channels\0chlist\0", 16), 0, 0xffffffff, "bytes that are not there"},
      {std::string("dataWindow\0box2i\0", 17), 0, 123, "box2i 123 bytes"},
      {std::string("channels\0chlist\0", 16), 4, 0x41414100, "list of channels"},
      {std::string("channels\0chlist\0", 16), 6, 3, "of type 3, which is none"},  // after "B"
      {std::string("dataWindow\0box2i\0", 17), 16, 1 << 13, "too short for its"},
  };
  for (const Lie& lie : lies) {
    Bytes changed = exr;
    const auto at = std::search(changed.begin(), changed.end(), lie.key.begin(), lie.key.end());
    ASSERT_NE(at, changed.end());
    std::memcpy(&*at + lie.key.size() + lie.at, &lie.word, sizeof(lie.word));
    write_bytes(path, changed);
    const Error error = error_of([&] { read_image(path); });
    EXPECT_EQ(error.kind(), ErrorKind::input);
    EXPECT_NE(std::string_view(error.what()).find(lie.said), std::string_view::npos)
        << error.what();
  }
}

TEST_F(ImageIo, UnwritableFolderIsAnOutputError) {
  const fs::path path = in_folder("missing") / "a.png";
  const Error error = error_of([&] { write_png(path, {1, 1, 3, {1, 2, 3}}); });
  EXPECT_EQ(error.kind(), ErrorKind::output);
}

}  // namespace
}  // namespace relume
