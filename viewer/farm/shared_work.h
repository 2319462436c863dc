#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/base/lock_file.h"
#include "core/base/progress.h"
#include "viewer/farm/team.h"

namespace relume {

/// Work cut into numbered items that processes share through a folder which all of them see. A
/// process claims an item by locking a byte, leaves its result as a file and marks it done; what a
/// process held when it died is claimed by another. Results stay in the folder until finish(): the
/// same command goes on there, with or without others. No process leads and none sends messages.
class SharedWork {
 public:
  using Bytes = std::vector<std::byte>;

  /// Joins the work in `folder`, or starts it. `settings` is the text of all that the results
  /// depend on: results of other settings are thrown away, and Error(output) tells that a process
  /// is still at work on them. Standard error is this process's own from here on (see speak()).
  SharedWork(const std::filesystem::path& folder, const std::string& settings, const Team& team);

  /// Returns the stage's number when all its items [0, count) have a result. `make` gives that of
  /// one item; it must depend on settings, stage and item alone. All processes go through the same
  /// stages. Throws Error(cancelled) after SIGINT; results so far stay.
  int complete(const std::string& name, size_t count, const std::function<Bytes(size_t item)>& make,
               const ProgressCallback& progress);

  /// What `make` gave. Throws Error(input) where the file is damaged.
  Bytes result(int stage, size_t item) const;

  /// One of the processes runs `last` and removes the folder, when all others have come here or
  /// died; they return after that. Where `last` throws, another tries. The work is over: nothing
  /// else may be called.
  void finish(const std::function<void()>& last);

 private:
  void join(const std::string& settings_hash);
  /// Makes the first item that is not marked and that nobody else is at; false where there is none.
  bool make_one(LockFile& claims, int stage, const std::string& marks,
                const std::function<Bytes(size_t item)>& make) const;
  bool is_checked_in() const;
  void remove_folder();
  std::filesystem::path result_path(int stage, size_t item) const;

  std::filesystem::path folder_;
  Team team_;
  int stages_ = 0;                   ///< begun
  std::optional<LockFile> members_;  ///< who takes part; see the .cpp
};

/// The folder for sharing the work on `output`, beside it.
std::filesystem::path work_folder(const std::filesystem::path& output);

/// True where processes share the work on `output`, or did when they were stopped.
bool is_shared(const std::filesystem::path& output, const Team& team);

}  // namespace relume
