#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
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

/// Files may not grow beyond so many bytes while this lives.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : on_exceeded_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, on_exceeded_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  void (*on_exceeded_)(int);
  rlimit before_{};
};

TEST(AtomicFile, WriteThatFailsHalfwayLeavesTheOldFile) {
  const TemporaryFolder folder;
  write_all(folder.file("a.bin"), "old");
  const FileSizeLimit limit(4);
  EXPECT_ERROR(write_file_atomic(folder.file("a.bin"), std::string("larger")), ErrorKind::output,
               "cannot write");
  EXPECT_EQ(read_all(folder.file("a.bin")), "old");
  EXPECT_EQ(folder.entry_count(), 1u);
}

TEST(AtomicFile, WritersOfOneFileDoNotDisturbEachOther) {
  const TemporaryFolder folder;
  const auto path = folder.file("a.bin");
  AtomicFile first(path);
  first.append(as_bytes("first"));
  {
    AtomicFile second(path);
    second.append(as_bytes("the second"));
    second.commit();
  }
  EXPECT_EQ(read_all(path), "the second");
  first.commit();
  EXPECT_EQ(read_all(path), "first");
  EXPECT_EQ(folder.entry_count(), 1u);
}

TEST(AtomicFile, RemovesWhatKilledWritersLeftAndNothingElse) {
  const TemporaryFolder folder;
  const auto abandoned = folder.file("other.exr.relume-tmp-0123456789abcdef");
  const auto alive = folder.file("a.bin.relume-tmp-fedcba9876543210");
  const auto foreign = folder.file("a.bin.relume-tmp-notes");
  for (const auto& path : {abandoned, alive, foreign}) write_all(path, "x");
  const int writer = open(alive.c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_EQ(flock(writer, LOCK_EX), 0);
  write_file_atomic(folder.file("a.bin"), std::string("new"));
  EXPECT_FALSE(std::filesystem::exists(abandoned));
  EXPECT_TRUE(std::filesystem::exists(alive));
  EXPECT_TRUE(std::filesystem::exists(foreign));
  close(writer);
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
