#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/base/mapped_file.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace relume {
namespace {

using test::TemporaryFolder;
using test::write_all;

TEST(MappedFile, ReadsTheBytes) {
  const TemporaryFolder folder;
  const std::string text("a\0b\xff", 4);
  write_all(folder.file("a"), text);
  MappedFile file(folder.file("a"));
  ASSERT_EQ(file.bytes().size(), 4u);
  EXPECT_EQ(std::to_integer<int>(file.bytes()[3]), 0xff);
  const MappedFile moved(std::move(file));
  EXPECT_EQ(moved.bytes().size(), 4u);
  EXPECT_TRUE(file.bytes().empty());  // NOLINT: moved-from state is documented by the default
}

TEST(MappedFile, EmptyFileIsAnEmptySpan) {
  const TemporaryFolder folder;
  write_all(folder.file("a"), "");
  EXPECT_TRUE(MappedFile(folder.file("a")).bytes().empty());
}

TEST(MappedFile, MissingFileAndFolderAreInputErrors) {
  const TemporaryFolder folder;
  EXPECT_ERROR(MappedFile(folder.file("none")), ErrorKind::input, "none");
  EXPECT_ERROR(MappedFile{folder.path()}, ErrorKind::input, "not a regular file");
}

/// Reads the last byte of a file that has lost it since it was mapped.
void read_behind_the_end(const std::filesystem::path& path) {
  install_mapping_guard();
  const MappedFile file(path);
  std::filesystem::resize_file(path, 0);
  const volatile std::byte last = file.bytes().back();
  (void)last;
}

TEST(MappedFileDeathTest, AFileThatIsShortenedEndsInOneLine) {
  const TemporaryFolder folder;
  const auto path = folder.file("short.relume");
  write_all(path, std::string(100000, 'a'));
  EXPECT_EXIT(read_behind_the_end(path), testing::ExitedWithCode(3), "short.relume: was shortened");
}

TEST(MappedFileDeathTest, OtherBusErrorsStayWhatTheyAre) {
  EXPECT_EXIT(
      {
        install_mapping_guard();
        (void)raise(SIGBUS);
        (void)raise(SIGBUS);
      },
      testing::KilledBySignal(SIGBUS), "");
}

TEST(MappedFile, MoreFilesThanTheGuardKnows) {
  const TemporaryFolder folder;
  write_all(folder.file("a"), "a");
  std::vector<MappedFile> files;
  for (int i = 0; i < 600; ++i) files.emplace_back(folder.file("a"));
  for (const MappedFile& file : files) EXPECT_EQ(std::to_integer<char>(file.bytes()[0]), 'a');
}

}  // namespace
}  // namespace relume
