#pragma once

#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace relume {

/// Writes the newest of a stream of texts to one file, atomically, on a thread of its own: saving
/// reaches the disk without anybody waiting for it. The destructor writes what is left.
class BackgroundWriter {
 public:
  BackgroundWriter();
  ~BackgroundWriter();
  BackgroundWriter(const BackgroundWriter&) = delete;
  BackgroundWriter& operator=(const BackgroundWriter&) = delete;

  /// Replaces what was not written yet. Makes the folder when missing.
  void write(std::filesystem::path path, std::string text);
  /// Removes `path` after all that was asked before.
  void remove(std::filesystem::path path);
  /// Blocks until nothing is left to do.
  void wait();
  /// What went wrong last, one line; empty = nothing.
  std::string problem() const;

 private:
  struct Task {
    std::filesystem::path path;
    std::optional<std::string> text;  ///< empty: remove the file
  };

  void submit(Task task);
  void run();
  static std::string perform(const Task& task);

  mutable std::mutex mutex_;  // guards the members below
  std::condition_variable wake_;
  std::condition_variable idle_;
  std::optional<Task> next_;
  bool running_ = false;
  bool quit_ = false;
  std::string problem_;
  std::thread thread_;  // last: starts when all else exists
};

}  // namespace relume
