#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "viewer/farm/shared_work.h"

namespace relume {

/// What a study has measured so far: numbers by key, in a text file that only grows, so that a
/// study that was killed goes on where it was. Each line carries a checksum: a line that the kill
/// cut short is dropped. Numbers are stored exactly. Used from one thread.
class TrialLog {
 public:
  /// Keeps nothing beyond this run.
  TrialLog() = default;

  /// Reads what `path` holds, or starts it. `settings` is the text of all that the figures depend
  /// on: a log made under other settings is started afresh. Throws Error(output).
  TrialLog(const std::filesystem::path& path, const std::string& settings);

  /// Shared with all processes of `work`: what complete() measures is kept there, and what `path`
  /// holds is only read. add() is not for such a log.
  TrialLog(const std::filesystem::path& path, const std::string& settings,
           std::unique_ptr<SharedWork> work);

  /// The numbers of `key`, or null where it was not measured yet.
  const std::vector<double>* find(const std::string& key) const;

  /// Adds a key that is not there yet, without tabs or line ends. Throws Error(output), for
  /// instance on a full disk.
  const std::vector<double>& add(const std::string& key, std::vector<double> values);

  /// Adds those of `keys` that are not there yet: `measure` gives the numbers of one, by its place
  /// among them, in their order. In a shared log each is measured by one of the processes.
  /// `stage` is what progress calls them.
  void complete(const std::string& stage, std::span<const std::string> keys,
                const std::function<std::vector<double>(size_t index)>& measure,
                const ProgressCallback& progress);

  /// How many keys came from an earlier run.
  size_t resumed() const { return resumed_; }

  /// The study is complete: calls `write` (of a shared log: in one of the processes), then removes
  /// the file.
  void finish(const std::function<void()>& write);

 private:
  bool read(const std::string& head);
  void complete_together(const std::string& stage, std::span<const std::string> keys,
                         const std::function<std::vector<double>(size_t index)>& measure,
                         const ProgressCallback& progress);
  void append(const std::string& text) const;

  std::filesystem::path path_;
  std::unique_ptr<SharedWork> work_;
  std::map<std::string, std::vector<double>> values_;
  size_t resumed_ = 0;
};

/// A 64-bit hash of text (FNV-1a), as 16 hexadecimal digits.
std::string hash_text(const std::string& text);

}  // namespace relume
