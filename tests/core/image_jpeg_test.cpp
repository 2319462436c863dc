#include <gtest/gtest.h>

#include "core/image/image_io.h"
#include "core/image/jpeg_segments.h"
#include "tests/support/expect_error.h"
#include "tests/support/oiiotool.h"
#include "tests/support/temporary_folder.h"

namespace relume::test {
namespace {

using namespace std::string_literals;

std::string without_metadata(const std::string& file) {
  const auto out = jpeg_without_metadata(std::as_bytes(std::span(file))).bytes;
  return {reinterpret_cast<const char*>(out.data()), out.size()};
}

/// A segment with its mark and length.
std::string segment(char marker, const std::string& body) {
  const size_t length = body.size() + 2;
  return "\xff"s + marker + static_cast<char>(length >> 8) + static_cast<char>(length & 255) + body;
}

const std::string start = "\xff\xd8"s;
const std::string jfif = segment('\xe0', "JFIF\0\1\1"s);
const std::string adobe = segment('\xee', "Adobe\0\x64"s);
const std::string tables = segment('\xdb', std::string(65, '\7'));
const std::string frame = segment('\xc0', std::string(15, '\1'));
const std::string scan = segment('\xda', std::string(6, '\0')) + "data\xff\0\xff\xd0more"s +
                         segment('\xe1', "after the first scan") + "\xff\xd9"s;
/// IPTC whose block says that it has 10,349 bytes.
const std::string iptc = segment('\xed',
                                 "Photoshop 3.0\0"
                                 "8BIM\4\4\0\0\0\0\x28\x6d\x1c\2\x2d"s);
const std::string exif = segment('\xe1', "Exif\0\0MM\0*\0\0\0\x08\xff\xff"s);

TEST(JpegSegments, OnlyThePictureStays) {
  const std::string picture = start + jfif + adobe + tables + frame + scan;
  EXPECT_EQ(without_metadata(picture), picture);
  EXPECT_EQ(
      without_metadata(start + exif + jfif + iptc + adobe + segment('\xe2', "ICC_PROFILE") +
                       tables + segment('\xfe', "a comment") + frame + segment('\xef', "") + scan),
      picture);
}

TEST(JpegSegments, NothingHidesBetweenThem) {
  const std::string picture = start + tables + frame + scan;
  EXPECT_EQ(without_metadata(start + "garbage\xff\0"s + iptc + "\xff\xff"s + iptc + tables + "\0"s +
                             frame + "\xff\xff\xff"s + scan),
            picture);
}

TEST(JpegSegments, OneThatIsCutShortIsTheEnd) {
  const std::string whole = start + tables + frame;
  for (const std::string& last : {iptc, tables}) {
    for (size_t size = 1; size < last.size(); ++size) {
      EXPECT_EQ(without_metadata(whole + last.substr(0, size)), whole) << size;
    }
  }
  EXPECT_EQ(without_metadata(start + "\xff\xe1\0\1"s + scan), start);
  EXPECT_EQ(without_metadata(""), "");
}

TEST(JpegSegments, SizesAreRefusedBeforeALibraryTakesMemoryForThem) {
  const TemporaryFolder folder;
  const auto path = folder.file("large.jpg");
  const auto write = [&](const std::string& size) {
    const std::string header = "\x08" + size + "\3" + std::string(9, '\1');
    write_all(path, start + tables + segment('\xc2', header) + scan);
  };
  write("\x30\x00\xdd\x10"s);
  EXPECT_ERROR(read_image(path), ErrorKind::limit, "56592 x 12288 pixels is too large");
  write("\x40\x00\x40\x00"s);
  EXPECT_ERROR(read_image(path), ErrorKind::input, "too few for 16384 x 16384 pixels");
}

TEST(JpegSegments, MetadataDoNotChangeThePicture) {
  if (!has_oiiotool()) GTEST_SKIP() << "no oiiotool";
  const TemporaryFolder folder;
  const auto path = folder.file("noise.jpg");
  ASSERT_TRUE(run_oiiotool("--pattern noise:type=uniform 37x21 3 -o " + path.string()));
  const Image image = read_image(path);
  std::string file = read_all(path);
  ASSERT_EQ(file.substr(0, 2), start);
  for (const std::string& metadata : {exif, iptc}) {
    write_all(path, start + metadata + file.substr(2));
    EXPECT_EQ(read_image(path).pixels, image.pixels);
    EXPECT_EQ(read_image_header(path).width, 37);
  }
}

}  // namespace
}  // namespace relume::test
