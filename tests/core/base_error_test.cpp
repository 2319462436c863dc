#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/label.h"
#include "core/base/progress.h"
#include "tests/support/expect_error.h"

namespace relume {
namespace {

TEST(Error, ReadsPlaceWhatMend) {
  const Error error = input_error("scene.json: /image", "is missing", "add it");
  EXPECT_STREQ(error.what(), "scene.json: /image: is missing; add it");
  EXPECT_EQ(error.exit_code(), 3);
  EXPECT_EQ(limit_error("a", "b", "c").exit_code(), 4);
  EXPECT_EQ(output_error("a", "b", "c").exit_code(), 5);
  EXPECT_EQ(Error(ErrorKind::usage, "x").exit_code(), 2);
  EXPECT_EQ(Error(ErrorKind::cancelled, "x").exit_code(), 130);
}

TEST(Error, HostileTextStaysOnOneShortLine) {
  const std::string hostile =
      "\x1b[2J\r\nrm -rf\t\x7f" + std::string(1, '\0') + std::string(9999, 'x');
  const std::string text = input_error(hostile, hostile, hostile).what();
  EXPECT_LT(text.size(), 1300u);
  for (const char c : text) {
    EXPECT_GE(static_cast<unsigned char>(c), 0x20);
    EXPECT_NE(c, 0x7f);
  }
}

TEST(Printable, KeepsUtf8AndShortTextAsItIs) {
  EXPECT_EQ(printable("Größe 5 m"), "Größe 5 m");
  EXPECT_EQ(printable(""), "");
  EXPECT_EQ(printable("12345", 5), "12345");
}

TEST(Printable, CutsAtTheByteAsked) {
  EXPECT_EQ(printable("123456", 5), "12345...");
}

TEST(Printable, NeverCutsThroughACharacter) {
  // "ö" is two bytes: a cut between them would leave bytes that are no text.
  const std::string cut = printable("123ö5678", 4);
  EXPECT_EQ(cut, "123...");
}

TEST(Printable, ReplacesC1ControlCharacters) {
  // U+009B, in UTF-8 the bytes C2 9B, starts an escape sequence on some terminals.
  const std::string text = printable(
      "a\xc2\x9b"
      "2Jb");
  EXPECT_EQ(text.find('\x9b'), std::string::npos);
}

enum class Fruit { apple, pear };
constexpr std::array fruit_labels = {Label<Fruit>{Fruit::apple, "apple"},
                                     Label<Fruit>{Fruit::pear, "pear"}};

TEST(Label, TableServesBothWays) {
  EXPECT_EQ(label_of(fruit_labels, Fruit::pear), "pear");
  EXPECT_EQ(label_of(fruit_labels, static_cast<Fruit>(7)), "?");
  EXPECT_EQ(value_of(fruit_labels, "apple"), Fruit::apple);
  EXPECT_EQ(value_of(fruit_labels, "Apple"), std::nullopt);
  EXPECT_EQ(label_list(fruit_labels), "apple, pear");
}

RareEvent counted_event("test event that fired");
RareEvent silent_event("test event that never fired");

TEST(RareEvent, ListsOnlyWhatFired) {
  silent_event.add(0);
  counted_event.add();
  counted_event.add(4);
  EXPECT_EQ(counted_event.count(), 5u);
  EXPECT_NE(rare_events().find("test event that fired: 5\n"), std::string::npos);
  EXPECT_EQ(rare_events().find("never"), std::string::npos);
}

TEST(CheckDeathTest, PrintsTheValues) {
  const int i = 7;
  EXPECT_DEATH(CHECK_MSG(i < 5, "i {}", i), "CHECK failed: i < 5: i 7");
}

TEST(Progress, ReportsTheEndAlwaysAndFractionsInRange) {
  std::vector<double> fractions;
  Progress progress(
      [&](const std::string& stage, double fraction, double) {
        EXPECT_EQ(stage, "tiles");
        fractions.push_back(fraction);
        return true;
      },
      "tiles");
  for (int i = 0; i <= 1000; ++i) progress.update(i, 1000);
  ASSERT_FALSE(fractions.empty());
  EXPECT_EQ(fractions.back(), 1.0);
  EXPECT_LT(fractions.size(), 100u);
  progress.update(12, 10);
  progress.update(0, 0);
  for (const double fraction : fractions) {
    EXPECT_GE(fraction, 0);
    EXPECT_LE(fraction, 1);
  }
}

TEST(Progress, StopsWithCancelledWhenTheCallbackSaysSo) {
  Progress progress([](const std::string&, double, double) { return false; }, "tiles");
  EXPECT_ERROR(progress.update(1, 2), ErrorKind::cancelled, "tiles");
  Progress silent({}, "none");
  silent.update(1, 2);
}

}  // namespace
}  // namespace relume
