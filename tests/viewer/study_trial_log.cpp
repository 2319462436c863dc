#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temporary_folder.h"
#include "viewer/study/trial_log.h"

namespace relume {
namespace {

using test::read_all;
using test::TemporaryFolder;

TEST(TrialLog, GivesBackWhatAnEarlierRunMeasuredToTheBit) {
  const TemporaryFolder folder;
  const std::vector<double> values{0.1, -1e-300, 3, 1.0 / 3};
  TrialLog first(folder.file("a.trials"), "settings");
  EXPECT_EQ(first.resumed(), 0u);
  first.add("hair 0", values);
  first.add("hair 1", {});
  const TrialLog second(folder.file("a.trials"), "settings");
  EXPECT_EQ(second.resumed(), 2u);
  ASSERT_NE(second.find("hair 0"), nullptr);
  EXPECT_EQ(*second.find("hair 0"), values);
  EXPECT_TRUE(second.find("hair 1")->empty());
  EXPECT_EQ(second.find("hair 2"), nullptr);
}

TEST(TrialLog, StartsAfreshUnderOtherSettings) {
  const TemporaryFolder folder;
  TrialLog(folder.file("a.trials"), "16 lights").add("hair 0", {1});
  const TrialLog other(folder.file("a.trials"), "50 lights");
  EXPECT_EQ(other.resumed(), 0u);
  EXPECT_EQ(other.find("hair 0"), nullptr);
  EXPECT_EQ(TrialLog(folder.file("a.trials"), "16 lights").resumed(), 0u);
}

TEST(TrialLog, DropsALineThatWasCutShortAndGoesOnBehindTheLastWholeOne) {
  const TemporaryFolder folder;
  const auto path = folder.file("a.trials");
  {
    TrialLog log(path, "settings");
    log.add("hair 0", {1.5});
    log.add("hair 1", {2.5, 3.5});
  }
  const std::string whole = read_all(path);
  const size_t second_line = whole.find("hair 1");
  for (size_t size = second_line; size < whole.size(); ++size) {
    std::ofstream(path, std::ios::binary) << whole.substr(0, size);
    TrialLog log(path, "settings");
    ASSERT_EQ(log.resumed(), 1u) << size;
    log.add("hair 1", {2.5, 3.5});
    ASSERT_EQ(read_all(path), whole) << size;
  }
}

TEST(TrialLog, DropsALineThatWasDamaged) {
  const TemporaryFolder folder;
  const auto path = folder.file("a.trials");
  TrialLog(path, "settings").add("hair 0", {1.5});
  std::string text = read_all(path);
  text[text.find("0x1.8")] = '1';
  std::ofstream(path, std::ios::binary) << text;
  EXPECT_EQ(TrialLog(path, "settings").resumed(), 0u);
}

TEST(TrialLog, KnowsThePublishedHashValues) {
  EXPECT_EQ(hash_text(""), "cbf29ce484222325");
  EXPECT_EQ(hash_text("a"), "af63dc4c8601ec8c");
  EXPECT_EQ(hash_text("foobar"), "85944171f73967e8");
}

}  // namespace
}  // namespace relume
