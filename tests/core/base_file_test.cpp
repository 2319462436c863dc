#include <gtest/gtest.h>

#include <utility>

#include "core/base/file.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace relume {
namespace {

using test::read_all;
using test::TemporaryFolder;
using test::write_all;

std::span<const std::byte> as_bytes(const std::string& text) {
  return std::as_bytes(std::span(text));
}

TEST(AtomicFile, CommitReplacesTheOldFile) {
  const TemporaryFolder folder;
  const auto path = folder.file("a.bin");
  write_all(path, "old contents, longer than the new ones");
  AtomicFile file(path);
  file.append(as_bytes("new "));
  file.append(as_bytes("bytes"));
  EXPECT_EQ(file.size(), 9u);
  EXPECT_EQ(read_all(path), "old contents, longer than the new ones");
  file.commit();
  EXPECT_EQ(read_all(path), "new bytes");
  EXPECT_EQ(folder.entry_count(), 1u);
}

TEST(AtomicFile, WithoutCommitTheOldFileStays) {
  const TemporaryFolder folder;
  const auto path = folder.file("a.bin");
  write_all(path, "old");
  {
    AtomicFile file(path);
    file.append(as_bytes("half of the ne"));
    EXPECT_EQ(folder.entry_count(), 2u);
  }
  EXPECT_EQ(read_all(path), "old");
  EXPECT_EQ(folder.entry_count(), 1u);
}

TEST(AtomicFile, WriteAtOverwritesInPlace) {
  const TemporaryFolder folder;
  AtomicFile file(folder.file("a.bin"));
  file.append(as_bytes("0123456789"));
  file.write_at(2, as_bytes("ab"));
  file.append(as_bytes("!"));
  file.commit();
  EXPECT_EQ(read_all(folder.file("a.bin")), "01ab456789!");
}

TEST(AtomicFile, MissingFolderIsAnOutputError) {
  const TemporaryFolder folder;
  EXPECT_ERROR(AtomicFile(folder.file("missing/a.bin")), ErrorKind::output, "missing/a.bin");
}

TEST(AtomicFile, FolderAsTargetIsAnOutputErrorAndLeavesNothing) {
  const TemporaryFolder folder;
  const auto target = folder.file("folder");
  std::filesystem::create_directories(target / "inside");
  {
    AtomicFile file(target);
    file.append(as_bytes("x"));
    EXPECT_ERROR(file.commit(), ErrorKind::output, "folder");
  }
  EXPECT_TRUE(std::filesystem::is_directory(target / "inside"));
  EXPECT_EQ(folder.entry_count(), 1u);
}

TEST(AtomicFile, FullDiskIsAnOutputError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "needs /dev/full";
  const TemporaryFolder folder;
  AtomicFile file(folder.file("a.bin"));
  std::filesystem::remove(file.temporary());
  std::filesystem::create_symlink("/dev/full", file.temporary());
  // The descriptor is open already; a second file of the same name now meets the full disk.
  AtomicFile full(folder.file("a.bin"));
  EXPECT_ERROR(full.append(as_bytes("x")), ErrorKind::output, "cannot write");
}

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

TEST(ReadTextFile, RefusesWhatIsLargerThanAsked) {
  const TemporaryFolder folder;
  write_all(folder.file("a"), "12345");
  EXPECT_EQ(read_text_file(folder.file("a"), 5), "12345");
  EXPECT_ERROR(read_text_file(folder.file("a"), 4), ErrorKind::limit, "5 bytes");
}

TEST(WriteFileAtomic, WritesTextAndEmptyFiles) {
  const TemporaryFolder folder;
  write_file_atomic(folder.file("a"), std::string("text"));
  EXPECT_EQ(read_all(folder.file("a")), "text");
  write_file_atomic(folder.file("a"), std::string());
  EXPECT_EQ(read_all(folder.file("a")), "");
}

}  // namespace
}  // namespace relume
