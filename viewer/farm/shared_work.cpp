#include "viewer/farm/shared_work.h"

#include <fmt/format.h>

#include <chrono>
#include <cstring>
#include <thread>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/mapped_file.h"
#include "core/base/timer.h"
#include "core/samples/cache_format.h"

namespace relume {
namespace {

// Bytes of the file "members".
constexpr uint64_t gate = 0;         ///< locked by whoever joins or removes the folder
constexpr uint64_t presence = 1;     ///< shared by all who use the folder's files
constexpr uint64_t last_word = 2;    ///< locked by whoever does the last part; 1 once that is done
constexpr uint64_t first_rank = 16;  ///< 1 once the rank has joined, rank by rank

constexpr char done = 1;

constexpr auto nap = std::chrono::milliseconds(20);

/// How long ranks that never came are waited for before the folder is removed: one that comes later
/// would find no work and do all of it again.
constexpr double patience_ms = 5e3;

void stop_if_interrupted(const std::filesystem::path& folder) {
  if (!interrupted()) return;
  throw Error(ErrorKind::cancelled,
              folder.string() + ": interrupted; the same command goes on there");
}

void wait_a_little(const std::filesystem::path& folder) {
  stop_if_interrupted(folder);
  std::this_thread::sleep_for(nap);
}

/// A lock of one byte while it is in scope.
class HeldByte {
 public:
  HeldByte(LockFile& file, uint64_t byte) : file_(file), byte_(byte), held_(file.try_lock(byte)) {}
  ~HeldByte() {
    if (held_) file_.unlock(byte_);
  }
  HeldByte(const HeldByte&) = delete;
  HeldByte& operator=(const HeldByte&) = delete;
  explicit operator bool() const { return held_; }

 private:
  LockFile& file_;
  uint64_t byte_;
  bool held_;
};

std::string hash_of(std::span<const std::byte> bytes) {
  return fmt::format("{:016x}", hash_bytes(bytes));
}

std::string read_settings(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored) ? read_text_file(path, 1 << 10) : std::string();
}

/// Not those above it.
void make_one_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directory(folder, error);
  if (error) {
    throw output_error(folder.string(), "cannot create: " + error.message(),
                       "check that the folder above it exists and is writable");
  }
}

/// All in `folder` but the file of members, which is locked.
void remove_results(const std::filesystem::path& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().filename() != "members") std::filesystem::remove_all(entry.path());
  }
}

}  // namespace

SharedWork::SharedWork(const std::filesystem::path& folder, const std::string& settings,
                       const Team& team)
    : folder_(folder), team_(team) {
  speak();
  join(hash_of(std::as_bytes(std::span(settings))));
}

void SharedWork::join(const std::string& settings_hash) {
  const std::filesystem::path settings_file = folder_ / "settings";
  for (;; wait_a_little(folder_)) {
    make_one_folder(folder_);
    members_.emplace(folder_ / "members");
    const HeldByte open_gate(*members_, gate);
    if (!open_gate || members_->is_removed()) continue;
    const bool is_first = members_->try_lock(presence);
    if (read_settings(settings_file) != settings_hash) {
      if (!is_first) {
        throw output_error(folder_.string(), "another command is at work there",
                           "wait for it, or choose another output");
      }
      remove_results(folder_);
      write_file_atomic(settings_file, settings_hash);
    }
    if (is_first) members_->clear();
    members_->try_share(presence);
    members_->write(first_rank + team_.rank, std::string(1, done));
    return;
  }
}

std::filesystem::path SharedWork::result_path(int stage, size_t item) const {
  return folder_ / fmt::format("{}.{:06}", stage, item);
}

bool SharedWork::make_one(LockFile& claims, int stage, const std::string& marks,
                          const std::function<Bytes(size_t item)>& make) const {
  for (size_t item = 0; item < marks.size(); ++item) {
    if (marks[item] == done) continue;
    const HeldByte claim(claims, item);
    if (!claim || claims.read(item, 1)[0] == done) continue;
    Bytes bytes = make(item);
    const uint64_t seal = hash_bytes(bytes);
    const auto* const at = reinterpret_cast<const std::byte*>(&seal);
    bytes.insert(bytes.end(), at, at + sizeof(seal));
    write_file_atomic(result_path(stage, item), std::span<const std::byte>(bytes));
    claims.write(item, std::string(1, done));
    return true;
  }
  return false;
}

int SharedWork::complete(const std::string& name, size_t count,
                         const std::function<Bytes(size_t item)>& make,
                         const ProgressCallback& callback) {
  const int stage = stages_++;
  LockFile claims(folder_ / fmt::format("{}.claims", stage));
  Progress progress(callback, name);
  for (;;) {
    stop_if_interrupted(folder_);
    const std::string marks = claims.read(0, count);
    const auto finished = std::count(marks.begin(), marks.end(), done);
    progress.update(static_cast<double>(finished), static_cast<double>(count));
    if (static_cast<size_t>(finished) == count) return stage;
    if (!make_one(claims, stage, marks, make)) wait_a_little(folder_);
  }
}

SharedWork::Bytes SharedWork::result(int stage, size_t item) const {
  const std::filesystem::path path = result_path(stage, item);
  const MappedFile file(path);
  const auto bytes = file.bytes();
  uint64_t seal = 0;
  const size_t size = bytes.size() - std::min(bytes.size(), sizeof(seal));
  const bool has_seal = bytes.size() >= sizeof(seal);
  if (has_seal) std::memcpy(&seal, bytes.data() + size, sizeof(seal));
  if (!has_seal || seal != hash_bytes(bytes.first(size))) {
    throw input_error(path.string(), "is damaged",
                      fmt::format("remove {} and run the command again", folder_.string()));
  }
  return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)};
}

bool SharedWork::is_checked_in() const {
  const std::string marks = members_->read(first_rank, static_cast<size_t>(team_.size));
  return std::count(marks.begin(), marks.end(), done) == team_.size;
}

void SharedWork::finish(const std::function<void()>& last) {
  const auto is_over = [this] { return members_->read(last_word, 1)[0] == done; };
  bool is_mine = false;
  while (!is_mine) {
    const HeldByte word(*members_, last_word);
    if (word && is_over()) break;
    if (word) {
      last();
      members_->write(last_word, std::string(1, done));
      is_mine = true;
    } else {
      wait_a_little(folder_);
    }
  }
  if (is_mine) return remove_folder();
  members_->unlock(presence);
  // Ranks that end with the one that cleans up leave their launcher no reason to kill it.
  const Timer timer;
  while (timer.ms() < patience_ms && !members_->is_removed()) wait_a_little(folder_);
}

void SharedWork::remove_folder() {
  const Timer timer;
  while (!is_checked_in() && timer.ms() < patience_ms) wait_a_little(folder_);
  for (;; wait_a_little(folder_)) {
    const HeldByte closed_gate(*members_, gate);
    if (!closed_gate || !members_->try_lock(presence)) continue;
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
    return;
  }
}

std::filesystem::path work_folder(const std::filesystem::path& output) {
  return output.string() + ".work";
}

bool is_shared(const std::filesystem::path& output, const Team& team) {
  std::error_code ignored;
  return !team.is_alone() || std::filesystem::is_directory(work_folder(output), ignored);
}

}  // namespace relume
