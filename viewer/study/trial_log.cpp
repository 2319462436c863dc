#include "viewer/study/trial_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

#include "core/base/check.h"
#include "core/base/error.h"

namespace relume {
namespace {

/// "key TAB numbers" with its checksum, hexadecimal floats.
std::string format_line(const std::string& key, std::span<const double> values) {
  std::string text = key + "\t";
  for (const double value : values) text += fmt::format("{:a} ", value);
  return fmt::format("{}\t{}\n", text, hash_text(text));
}

/// The key and the numbers of a whole line; nothing when it is damaged.
std::optional<std::pair<std::string, std::vector<double>>> parse_line(const std::string& line) {
  const size_t key_end = line.find('\t');
  const size_t text_end = line.rfind('\t');
  if (key_end == std::string::npos || text_end == key_end) return std::nullopt;
  if (line.substr(text_end + 1) != hash_text(line.substr(0, text_end))) return std::nullopt;
  std::vector<double> values;
  const char* at = line.c_str() + key_end + 1;
  while (at < line.c_str() + text_end) {
    char* end = nullptr;
    values.push_back(std::strtod(at, &end));
    at = end + 1;
  }
  return std::pair{line.substr(0, key_end), std::move(values)};
}

std::string head_of(const std::string& settings) {
  return fmt::format("relume-trials-1 {}\n", hash_text(settings));
}

std::vector<std::byte> to_bytes(std::span<const double> values) {
  const auto bytes = std::as_bytes(values);
  return {bytes.begin(), bytes.end()};
}

std::vector<double> to_numbers(std::span<const std::byte> bytes) {
  std::vector<double> values(bytes.size() / sizeof(double));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(double));
  return values;
}

}  // namespace

std::string hash_text(const std::string& text) {
  uint64_t hash = 0xcbf29ce484222325u;
  for (const char letter : text) {
    hash = (hash ^ static_cast<unsigned char>(letter)) * 0x100000001b3u;
  }
  return fmt::format("{:016x}", hash);
}

TrialLog::TrialLog(const std::filesystem::path& path, const std::string& settings) : path_(path) {
  const std::string head = head_of(settings);
  if (read(head)) return;
  values_.clear();
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
  append(head);
}

TrialLog::TrialLog(const std::filesystem::path& path, const std::string& settings,
                   std::unique_ptr<SharedWork> work)
    : path_(path), work_(std::move(work)) {
  if (!read(head_of(settings))) values_.clear();
}

bool TrialLog::read(const std::string& head) {
  std::ifstream file(path_, std::ios::binary);
  std::stringstream buffer;
  buffer << file.rdbuf();
  const std::string text = buffer.str();
  if (!file || !text.starts_with(head)) return false;
  size_t at = head.size();
  for (size_t end = text.find('\n', at); end != std::string::npos; end = text.find('\n', at)) {
    auto entry = parse_line(text.substr(at, end - at));
    if (!entry) break;
    values_.insert(std::move(*entry));
    at = end + 1;
  }
  resumed_ = values_.size();
  std::error_code failure;
  if (at < text.size() && !work_) std::filesystem::resize_file(path_, at, failure);
  return !failure;
}

const std::vector<double>* TrialLog::find(const std::string& key) const {
  const auto found = values_.find(key);
  return found == values_.end() ? nullptr : &found->second;
}

const std::vector<double>& TrialLog::add(const std::string& key, std::vector<double> values) {
  CHECK_MSG(key.find_first_of("\t\n") == std::string::npos && !work_, "key {}", key);
  const auto [entry, is_new] = values_.emplace(key, std::move(values));
  CHECK_MSG(is_new, "key {}", key);
  if (!path_.empty()) append(format_line(key, entry->second));
  return entry->second;
}

void TrialLog::append(const std::string& text) const {
  std::ofstream file(path_, std::ios::binary | std::ios::app);
  file << text << std::flush;
  if (!file) {
    throw Error(ErrorKind::output,
                fmt::format("{}: cannot be written; is the disk full?", path_.string()));
  }
}

void TrialLog::complete(const std::string& stage, std::span<const std::string> keys,
                        const std::function<std::vector<double>(size_t index)>& measure,
                        const ProgressCallback& callback) {
  if (work_) return complete_together(stage, keys, measure, callback);
  Progress progress(callback, stage);
  const auto is_missing = [this](const std::string& key) { return find(key) == nullptr; };
  const auto missing = static_cast<double>(std::ranges::count_if(keys, is_missing));
  double measured = 0;
  for (size_t i = 0; i < keys.size(); ++i) {
    if (!is_missing(keys[i])) continue;
    add(keys[i], measure(i));
    progress.update(++measured, missing);
  }
}

void TrialLog::complete_together(const std::string& stage, std::span<const std::string> keys,
                                 const std::function<std::vector<double>(size_t index)>& measure,
                                 const ProgressCallback& callback) {
  const auto make = [&](size_t i) {
    const std::vector<double>* const known = find(keys[i]);
    return to_bytes(known != nullptr ? *known : measure(i));
  };
  const int shared = work_->complete(stage, keys.size(), make, callback);
  for (size_t i = 0; i < keys.size(); ++i) {
    values_.emplace(keys[i], to_numbers(work_->result(shared, i)));
  }
}

void TrialLog::finish(const std::function<void()>& write) {
  const auto write_and_remove = [&] {
    write();
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove(path_, ignored);
  };
  if (work_) return work_->finish(write_and_remove);
  write_and_remove();
}

}  // namespace relume
