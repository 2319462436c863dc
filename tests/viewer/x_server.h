#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "tests/viewer/child_process.h"

namespace relume {

/// A virtual X server on a display of its own choice, for the life of the test, and a person's
/// hands on it.
class Window : public testing::Test {
 protected:
  void SetUp() override {
    using namespace std::chrono_literals;
    server_ = std::make_unique<ChildProcess>(
        std::vector<std::string>{"Xvfb", "-displayfd", "1", "-screen", "0", "1400x1000x24",
                                 "-nolisten", "tcp"},
        std::map<std::string, std::string>{}, true);
    const std::string number = server_->started() ? server_->read_line(20s) : "";
    if (number.empty()) GTEST_SKIP() << "needs Xvfb: apt-get install xvfb";
    display_ = ":" + number;
  }

  /// Runs xdotool; its exit code.
  int xdotool(std::vector<std::string> arguments) const {
    using namespace std::chrono_literals;
    arguments.insert(arguments.begin(), "xdotool");
    ChildProcess process(arguments, {{"DISPLAY", display_}}, true);
    return process.started() ? process.wait(20s) : -1;
  }

  std::unique_ptr<ChildProcess> server_;
  std::string display_;
};

}  // namespace relume
