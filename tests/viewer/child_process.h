#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

namespace relume {

/// A program that runs beside the test. The destructor ends it.
class ChildProcess {
 public:
  /// Starts `arguments[0]` (found through PATH) with `environment` on top of ours. With
  /// `reads_output` its standard output can be read. A program that does not exist makes started()
  /// false.
  ChildProcess(const std::vector<std::string>& arguments,
               const std::map<std::string, std::string>& environment, bool reads_output = false);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  bool started() const { return pid_ > 0; }
  /// The next line of its standard output, or what came of it within `patience`.
  std::string read_line(std::chrono::milliseconds patience);
  /// Ends it on the spot, as `kill -9` does.
  void kill_hard();
  /// Its exit code; -1 when it ended otherwise or not within `patience`.
  int wait(std::chrono::milliseconds patience);

 private:
  int pid_ = -1;
  int output_ = -1;
};

}  // namespace relume
