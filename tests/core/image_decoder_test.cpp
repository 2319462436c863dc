// Images that are decoded in a process of their own (core/image/decoder_process.h).

#include <gtest/gtest.h>
#include <signal.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "core/base/error.h"
#include "core/image/decoder_process.h"
#include "core/image/image_io.h"
#include "core/math/color.h"
#include "core/scene/io/texture_file.h"
#include "tests/support/temporary_folder.h"

namespace relume {
namespace {

namespace fs = std::filesystem;
using Bytes = std::string;

template <class Integer>
void append(Bytes& bytes, Integer value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

/// 2 x 2 pixels: red, green; blue, white.
Bytes make_bmp() {
  Bytes bytes = "BM";
  append<uint32_t>(bytes, 14 + 40 + 16);
  append<uint32_t>(bytes, 0);
  append<uint32_t>(bytes, 14 + 40);
  for (const uint32_t word : {40u, 2u, 2u, 1u | 24u << 16, 0u, 16u, 0u, 0u, 0u, 0u}) {
    append(bytes, word);
  }
  bytes += Bytes("\xff\0\0\xff\xff\xff\0\0", 8);  // from the bottom, blue first, rows of 8 bytes
  bytes += Bytes("\0\0\xff\0\xff\0\0\0", 8);
  return bytes;
}

Bytes make_targa() {
  Bytes bytes("\0\0\2\0\0\0\0\0\0\0\0\0\2\0\2\0\x18\x20", 18);  // from the top
  return bytes + Bytes("\0\0\xff\0\xff\0\xff\0\0\xff\xff\xff", 12);
}

Bytes make_radiance() {
  const Bytes head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n";
  return head + Bytes("\x80\0\0\x81\0\x80\0\x81\0\0\x80\x81\x80\x80\x80\x81", 16);
}

/// Little-endian, one strip, no compression. Values are bytes or floats.
Bytes make_tiff(uint32_t width, uint32_t height, uint16_t channels, const Bytes& values,
                bool is_float = false) {
  Bytes bytes("II*\0\x08\0\0\0", 8);
  struct Entry {
    uint16_t tag;
    uint16_t type;  ///< 3: 16 bits, 4: 32 bits
    uint32_t value;
  };
  const uint32_t bits = is_float ? 32 : 8;
  const std::vector<Entry> entries = {{256, 4, width},
                                      {257, 4, height},
                                      {258, 3, bits},
                                      {259, 3, 1},
                                      {262, 3, channels < 3u ? 1u : 2u},
                                      {273, 4, 0},
                                      {277, 3, channels},
                                      {278, 4, height},
                                      {279, 4, static_cast<uint32_t>(values.size())},
                                      {339, 3, is_float ? 3u : 1u}};
  const size_t data = bytes.size() + 2 + entries.size() * 12 + 4;
  append<uint16_t>(bytes, static_cast<uint16_t>(entries.size()));
  for (const Entry& entry : entries) {
    append(bytes, entry.tag);
    append(bytes, entry.type);
    append<uint32_t>(bytes, 1);
    append(bytes, entry.tag == 273 ? static_cast<uint32_t>(data) : entry.value);
  }
  append<uint32_t>(bytes, 0);
  return bytes + values;
}

class Decoder : public testing::Test {
 protected:
  fs::path write(const std::string& name, const Bytes& bytes) const {
    const fs::path path = folder_.file(name);
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }

  const test::TemporaryFolder folder_;
};

Error error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(std::string_view(error.what()).find('\n'), std::string_view::npos);
    return error;
  }
  ADD_FAILURE() << "no Error was thrown";
  return Error(ErrorKind::usage, "none");
}

bool mentions(const char* message, std::string_view text) {
  return std::string_view(message).find(text) != std::string_view::npos;
}

/// The children of this process.
std::vector<pid_t> children() {
  std::vector<pid_t> found;
  for (const auto& thread : fs::directory_iterator("/proc/self/task")) {
    std::ifstream list(thread.path() / "children");
    for (pid_t id = 0; list >> id;) found.push_back(id);
  }
  return found;
}

TEST_F(Decoder, ReadsEveryFormat) {
  const Bytes pixels("\xff\0\0\0\xff\0\0\0\xff\xff\xff\xff", 12);
  const std::vector<uint8_t> expected = {255, 0, 0,   255, 0,   255, 0,   255,
                                         0,   0, 255, 255, 255, 255, 255, 255};
  const fs::path paths[] = {write("a.bmp", make_bmp()), write("a.tga", make_targa()),
                            write("a.hdr", make_radiance()),
                            write("a.tif", make_tiff(2, 2, 3, pixels))};
  for (const fs::path& path : paths) {
    Scene scene;
    add_texture(scene, path, true, "test");
    EXPECT_EQ(scene.textures[0].texels, expected) << path;
    const Image image = read_image(path);
    EXPECT_EQ(image.width, 2);
    EXPECT_EQ(image.height, 2);
    EXPECT_FLOAT_EQ(image.at(1, 0)[1], 1) << path;
    EXPECT_FLOAT_EQ(image.at(1, 0)[0], 0) << path;
    EXPECT_EQ(read_image_header(path).channels.size(), 3u) << path;
  }
  EXPECT_LE(children().size(), 1u) << "one decoder waits";
}

TEST_F(Decoder, GivesTheSameValuesAsThisProcess) {
  Bytes values;
  for (int i = 0; i < 40 * 30; ++i) append(values, 0.37f * static_cast<float>(i) - 100);
  const fs::path path = write("float.tif", make_tiff(40, 30, 1, values, true));
  std::vector<float> here;
  std::vector<float> outside;
  const ImageSource source{path, path.string()};
  const auto read = [](ImageInput& input, std::vector<float>& out) {
    input.read_rows([&](int, const float* row) {
      out.insert(out.end(), row, row + input.spec().row_values());
    });
  };
  read(*open_image_here(source), here);
  read(*open_in_decoder(source), outside);
  EXPECT_EQ(here.size(), 1200u);
  EXPECT_EQ(here, outside);
  EXPECT_EQ(here[1199], 0.37f * 1199 - 100);
}

TEST_F(Decoder, FormatsAreWhatTheirBytesSay) {
  Scene scene;
  EXPECT_EQ(add_texture(scene, write("really_bmp.png", make_bmp()), true, "test"), 0);
  const Error unknown =
      error_of([&] { read_image(write("sgi.png", Bytes("\x01\xda\x01\x01", 4) + Bytes(600, 0))); });
  EXPECT_EQ(unknown.kind(), ErrorKind::input);
  EXPECT_TRUE(mentions(unknown.what(), "no format that is known"));
}

TEST_F(Decoder, TrustedFormatsStartNoProcess) {
  for (const pid_t decoder : children()) kill(decoder, SIGKILL);  // of earlier tests
  const std::vector<pid_t> before = children();
  const Image picture(3, 2);
  const fs::path exr = folder_.file("a.exr");
  write_exr(exr, std::vector<ExrLayer>{{"", {"R", "G", "B"}, &picture}});
  const fs::path png = folder_.file("a.png");
  write_png(png, {1, 1, 3, {1, 2, 3}});
  read_image(exr);
  read_image(png);
  EXPECT_EQ(children(), before);
}

TEST_F(Decoder, LeavesNoFileOpen) {
  const auto open_files = [] {
    return std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator());
  };
  const fs::path path = write("a.bmp", make_bmp());
  read_image(path);
  const auto before = open_files();
  for (int i = 0; i < 3; ++i) {
    for (const pid_t decoder : children()) kill(decoder, SIGKILL);
    EXPECT_EQ(read_image(path).width, 2) << "by another one";
  }
  EXPECT_EQ(open_files(), before);
}

TEST_F(Decoder, StaysForTheNextImageWhenRowsAreNotWanted) {
  Bytes values;
  for (int i = 0; i < 40 * 30; ++i) append(values, std::numeric_limits<float>::infinity());
  const fs::path broken = write("infinite.tif", make_tiff(40, 30, 1, values, true));
  EXPECT_TRUE(mentions(error_of([&] { read_image(broken); }).what(), "not finite"));
  const std::vector<pid_t> first = children();
  ASSERT_EQ(first.size(), 1u);
  EXPECT_TRUE(mentions(error_of([&] { read_image(broken); }).what(), "not finite"));
  EXPECT_EQ(read_image(write("a.bmp", make_bmp())).width, 2);
  EXPECT_EQ(children(), first);
}

TEST_F(Decoder, CutFilesAreOneErrorThatNamesThem) {
  const Bytes pixels(size_t{64} * 64 * 3, '\x40');
  for (const auto& [name, whole] :
       {std::pair{"cut.bmp", make_bmp()}, std::pair{"cut.tga", make_targa()},
        std::pair{"cut.tif", make_tiff(64, 64, 3, pixels)}}) {
    const fs::path path = write(name, whole.substr(0, whole.size() / 2));
    const Error error = error_of([&] { read_image(path); });
    EXPECT_EQ(error.kind(), ErrorKind::input) << error.what();
    EXPECT_TRUE(std::string_view(error.what()).starts_with(path.string() + ": ")) << error.what();
  }
}

TEST_F(Decoder, HugeSizesAreRefused) {
  const fs::path path = write("huge.tif", make_tiff(20000, 20000, 3, "abc"));
  const Error error = error_of([&] { read_image(path); });
  EXPECT_EQ(error.kind(), ErrorKind::limit) << error.what();
  EXPECT_TRUE(mentions(error.what(), "20000 x 20000"));
  const fs::path empty = write("empty.tif", make_tiff(16384, 16384, 4, "abc", true));
  EXPECT_TRUE(mentions(error_of([&] { read_image(empty); }).what(), "empty.tif"));
}

TEST_F(Decoder, ACrashOfTheLibraryIsAnErrorLikeAnyOther) {
  // More than fits into the socket, so that the decoder still lives when its first row arrives.
  const Bytes values(size_t{2048} * 2048, '\x40');
  const fs::path path = write("large.tif", make_tiff(2048, 2048, 1, values));
  const std::vector<std::string> channels = read_image_header(path).channels;
  const std::vector<std::pair<int, std::string>> ends = {{SIGSEGV, "cannot read the image"},
                                                         {SIGABRT, "ended by signal 6"},
                                                         {SIGXCPU, "takes too long"},
                                                         {SIGKILL, "signal 9"}};
  for (const auto& [signal, expected] : ends) {
    int rows = 0;
    const Error error = error_of([&] {
      read_channel_rows(path, channels, [&](int, std::span<const float>) {
        if (rows++ > 0) return;
        const std::vector<pid_t> decoders = children();
        ASSERT_EQ(decoders.size(), 1u);
        kill(decoders[0], signal);
      });
    });
    EXPECT_LT(rows, 2048);
    EXPECT_TRUE(mentions(error.what(), expected));
    EXPECT_TRUE(std::string_view(error.what()).starts_with(path.string()));
  }
  EXPECT_TRUE(children().empty());
  EXPECT_EQ(read_image(path).width, 2048) << "another decoder is started";
}

}  // namespace
}  // namespace relume
