// The manual page and the completion of the shell say what the program says.

#include <gtest/gtest.h>

#include <array>
#include <memory>

#include "tests/support/temporary_folder.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/program_pages.h"

namespace relume::test {
namespace {

std::string page(const char* command) {
  const std::array arguments = {"relume", command};
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_command_line(static_cast<int>(arguments.size()), arguments.data()), 0);
  return testing::internal::GetCapturedStdout();
}

/// What a shell command prints.
std::string shell(const std::string& command) {
  const auto close = [](FILE* pipe) { pclose(pipe); };
  const std::unique_ptr<FILE, decltype(close)> pipe(popen(command.c_str(), "r"), close);
  std::string out;
  std::array<char, 256> buffer{};
  while (fgets(buffer.data(), buffer.size(), pipe.get()) != nullptr) out += buffer.data();
  return out;
}

/// What bash offers for the words of a command line, of which the last is being typed.
std::string complete(const std::string& words) {
  const TemporaryFolder folder;
  write_all(folder.file("completion"), page("completion"));
  return shell("bash -c 'source " + folder.file("completion").string() + "; COMP_WORDS=(" + words +
               "); COMP_CWORD=$((${#COMP_WORDS[@]}-1)); _relume; echo ${COMPREPLY[@]}'");
}

TEST(Pages, ManualHasEveryCommandAndItsOptions) {
  const std::string manual = page("manual");
  for (const char* part : {".SS demo", ".SS prepare", ".SS render", ".SS verify", ".SS study",
                           "\\fB\\-\\-shadow\\fR", "\\fB\\-\\-average\\-records\\fR",
                           "relume render hair \\-\\-reference", ".SH EXIT STATUS"}) {
    EXPECT_NE(manual.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(manual, page("manual"));
}

TEST(Pages, ManualFormatsWithoutAWarning) {
  if (std::system("command -v groff >/dev/null") != 0) GTEST_SKIP() << "groff is not installed";
  const TemporaryFolder folder;
  write_all(folder.file("page"), page("manual"));
  EXPECT_EQ(shell("groff -man -Tutf8 -ww " + folder.file("page").string() + " 2>&1 >/dev/null"),
            "");
}

TEST(Pages, CompletionOffersCommandsOptionsAndValues) {
  EXPECT_EQ(complete("relume ver"), "verify\n");
  EXPECT_EQ(complete("relume render --predicted"), "--predicted-error\n");
  EXPECT_EQ(complete("relume render hair --shadow co"), "coverage\n");
  EXPECT_EQ(complete("relume prepare hair --method light-fit-"), "light-fit-fast\n");
  EXPECT_EQ(complete("relume compare " RELUME_SOURCE_DIR "/READ"),
            RELUME_SOURCE_DIR "/README.md\n");
}

TEST(Pages, ValuesAreThoseThatHelpListsAtItsEnd) {
  EXPECT_EQ(listed_values("shadow method: none, ray"), (std::vector<std::string>{"none", "ray"}));
  EXPECT_TRUE(listed_values("budget: every pixel its own k, so many on average").empty());
  EXPECT_TRUE(listed_values("a picture").empty());
  EXPECT_TRUE(listed_values("minutes: ").empty());
}

}  // namespace
}  // namespace relume::test
