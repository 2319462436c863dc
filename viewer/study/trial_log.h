#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

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

  /// The numbers of `key`, or null where it was not measured yet.
  const std::vector<double>* find(const std::string& key) const;

  /// Adds a key that is not there yet, without tabs or line ends. Throws Error(output), for
  /// instance on a full disk.
  const std::vector<double>& add(const std::string& key, std::vector<double> values);

  /// How many keys came from an earlier run.
  size_t resumed() const { return resumed_; }

  /// Removes the file: the study is complete.
  void remove();

 private:
  bool read(const std::string& head);
  void append(const std::string& text) const;

  std::filesystem::path path_;
  std::map<std::string, std::vector<double>> values_;
  size_t resumed_ = 0;
};

/// A 64-bit hash of text (FNV-1a), as 16 hexadecimal digits.
std::string hash_text(const std::string& text);

}  // namespace relume
