#pragma once

#include <filesystem>
#include <span>
#include <string_view>

namespace relume::test {

/// One of our readers, as hostile files meet it.
struct ReadTarget {
  std::string_view name;
  std::string_view extension;  ///< that its files have, with the dot
  /// Reads all that the file holds. Throws Error(input) or Error(limit); anything else is a defect.
  void (*read)(const std::filesystem::path& path);
  bool is_decoded_outside = false;  ///< in relume-decode, which libFuzzer does not see
};

/// All of them: whatever the program reads from outside has one.
std::span<const ReadTarget> read_targets();

/// Null when there is none of that name.
const ReadTarget* find_read_target(std::string_view name);

/// A folder in memory for a hostile file, beside a copy of the right files (tests/fuzz/make_seeds
/// writes them to "companions") that it names by "../companions/NAME". It is removed at the end.
class HostileFolder {
 public:
  /// `seeds`: the folder that make_seeds wrote; empty: no companions.
  explicit HostileFolder(const std::filesystem::path& seeds);
  ~HostileFolder();
  HostileFolder(const HostileFolder&) = delete;
  HostileFolder& operator=(const HostileFolder&) = delete;

  std::filesystem::path file(const ReadTarget& target) const;

 private:
  std::filesystem::path root_;
};

enum class ReadResult { accepted, refused };

/// Reads `path`. A refusal must be one line that names the file; what is not one, or another
/// exception, ends in std::logic_error with the message.
ReadResult read_checked(const ReadTarget& target, const std::filesystem::path& path);

}  // namespace relume::test
