#include <gtest/gtest.h>

#include <filesystem>
#include <optional>

#include "core/base/lock_file.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace relume {
namespace {

using test::TemporaryFolder;

class LockFileTest : public testing::Test {
 protected:
  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.file("locks");
};

TEST_F(LockFileTest, OneHoldsAByteAloneUntilItGivesItBack) {
  LockFile first(path_);
  LockFile second(path_);
  EXPECT_TRUE(first.try_lock(3));
  EXPECT_TRUE(first.try_lock(3)) << "its own";
  EXPECT_FALSE(second.try_lock(3));
  EXPECT_FALSE(second.try_share(3));
  EXPECT_TRUE(second.try_lock(2));
  EXPECT_TRUE(second.try_lock(4));
  first.unlock(3);
  EXPECT_TRUE(second.try_lock(3));
  EXPECT_FALSE(first.try_lock(3));
}

TEST_F(LockFileTest, ManyShareAByteThatNobodyHoldsAlone) {
  LockFile first(path_);
  LockFile second(path_);
  EXPECT_TRUE(first.try_lock(0));
  EXPECT_TRUE(first.try_share(0)) << "turns its own into a shared one";
  EXPECT_TRUE(second.try_share(0));
  EXPECT_FALSE(first.try_lock(0));
  second.unlock(0);
  EXPECT_TRUE(first.try_lock(0));
}

TEST_F(LockFileTest, TheEndOfAHolderFreesWhatItHeld) {
  std::optional<LockFile> first;
  first.emplace(path_);
  LockFile second(path_);
  EXPECT_TRUE(first->try_lock(7));
  first.reset();
  EXPECT_TRUE(second.try_lock(7));
}

TEST_F(LockFileTest, HoldsWhatTheLastOneWrote) {
  LockFile first(path_);
  const LockFile second(path_);
  EXPECT_EQ(second.read(0, 3), std::string(3, '\0'));
  first.write(2, "abcd");
  EXPECT_EQ(second.read(1, 8), std::string("\0abcd\0\0\0", 8));
  first.clear();
  EXPECT_EQ(second.read(2, 4), std::string(4, '\0'));
}

TEST_F(LockFileTest, KnowsThatItsNameIsGone) {
  const LockFile file(path_);
  EXPECT_FALSE(file.is_removed());
  std::filesystem::remove(path_);
  EXPECT_TRUE(file.is_removed());
  EXPECT_ERROR(LockFile(folder_.file("missing/locks")), ErrorKind::output, "missing/locks");
}

}  // namespace
}  // namespace relume
