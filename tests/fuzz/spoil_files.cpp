// Spoils right files in every way that files go wrong and gives them to the readers: cut short at
// every step, each byte and word changed, numbers of texts made extreme, lines and parts taken out
// and doubled. Each has to be read or refused by one clear line, in 2 seconds and in twice the
// file's size plus 256 MiB of memory.
//
// Usage: spoil_files SEEDS [FILES_A_FORMAT [TARGET...]]   (SEEDS: made by tests/fuzz/make_seeds)
// Prints a JSON document; files that break a promise stay in the folder SEEDS/broken. Exits with 1
// where one did.

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/read_targets.h"

namespace relume::test {
namespace {

namespace fs = std::filesystem;
using Bytes = std::string;

constexpr double most_ms = 2000;
constexpr int64_t most_extra_kib = 256 * 1024;
constexpr size_t files_a_child = 256;

Bytes bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

bool is_text(const Bytes& file) {
  return std::ranges::all_of(file, [](char c) { return c == '\n' || c == '\t' || c >= ' '; });
}

/// One of the ways to spoil a file, chosen by number; the same number gives the same file.
class Spoiler {
 public:
  explicit Spoiler(Bytes seed) : seed_(std::move(seed)), is_text_(is_text(seed_)) {
    for (size_t i = 0; i < seed_.size(); ++i) {
      const bool starts =
          std::isdigit(static_cast<unsigned char>(seed_[i])) != 0 || seed_[i] == '-';
      const bool goes_on = i > 0 && (std::isalnum(static_cast<unsigned char>(seed_[i - 1])) != 0 ||
                                     seed_[i - 1] == '.' || seed_[i - 1] == '-');
      if (starts && !goes_on) numbers_.push_back(i);
    }
  }

  /// First every cut and every change of a byte at the front, evenly thinned out where there are
  /// more than asked for; then changes at random.
  Bytes spoil(size_t number, size_t count) const {
    const size_t cuts = std::min(seed_.size(), count / 4);
    if (number < cuts) return seed_.substr(0, number * seed_.size() / cuts);
    number -= cuts;
    const size_t front = std::min<size_t>(seed_.size(), 1024);
    const size_t changes = std::min(front * std::size(byte_values), count / 4);
    if (number < changes) {
      Bytes file = seed_;
      const size_t change = number * front * std::size(byte_values) / changes;
      char& byte = file[change / std::size(byte_values)];
      const int value = byte_values[change % std::size(byte_values)];
      byte = static_cast<char>(value < 0 ? ~byte : value);
      return file;
    }
    return spoil_at_random(number);
  }

 private:
  static constexpr int byte_values[] = {0, 0x7f, 0x80, 0xff, -1};
  static constexpr const char* extreme_numbers[] = {
      "0",    "-1",    "1e30", "-1e30", "1e-30",      "1e999",       "NaN",
      "null", "65536", "true", "1e6",   "2147483648", "-2147483649", "99999999999999999999",
      "\"\"", "[]",    "{}",   "0.5"};
  static constexpr uint32_t extreme_words[] = {0,          1,          0x7fffffff, 0x80000000,
                                               0xffffffff, 0xfffffffe, 0x7f800000, 0x7fc00000,
                                               0x00010000, 0x3fffffff, 0x10000000, 0x0000ffff};

  Bytes spoil_at_random(size_t number) const {
    std::mt19937_64 random(number);
    const auto below = [&](size_t n) {
      return static_cast<size_t>(random() % std::max<size_t>(1, n));
    };
    Bytes file = seed_;
    const size_t steps = 1 + below(3);
    for (size_t i = 0; i < steps && !file.empty(); ++i) {
      const size_t at = below(file.size());
      switch (below(is_text_ ? 6 : 5)) {
        case 0:
          file[at] = static_cast<char>(random());
          break;
        case 1: {
          const uint32_t word = extreme_words[below(std::size(extreme_words))];
          const size_t aligned = at / 4 * 4;
          if (aligned + sizeof(word) <= file.size())
            std::memcpy(&file[aligned], &word, sizeof(word));
          break;
        }
        case 2:
          file.erase(at, 1 + below(64));
          break;
        case 3:
          file.insert(at, file.substr(below(file.size()), 1 + below(64)));
          break;
        case 4:
          std::reverse(file.begin() + static_cast<std::ptrdiff_t>(at),
                       file.begin() + static_cast<std::ptrdiff_t>(std::min(file.size(), at + 8)));
          break;
        default:
          if (i == 0 && !numbers_.empty())
            replace_number(file, numbers_[below(numbers_.size())], random());
      }
    }
    return file;
  }

  static void replace_number(Bytes& file, size_t at, uint64_t choice) {
    size_t end = at + 1;
    while (end < file.size() && (std::isalnum(static_cast<unsigned char>(file[end])) != 0 ||
                                 file[end] == '.' || file[end] == '-')) {
      ++end;
    }
    file.replace(at, end - at, extreme_numbers[choice % std::size(extreme_numbers)]);
  }

  Bytes seed_;
  bool is_text_;
  std::vector<size_t> numbers_;  ///< where they begin
};

/// What a child tells of one file.
struct Outcome {
  enum State : int { waiting, begun, accepted, refused, wrong } state;
  float ms;
  int64_t grown_kib;  ///< beyond twice the file's size
  char message[240];
};

/// A line of /proc/self/status, in KiB.
int64_t status_kib(std::string_view name) {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with(name)) return std::stoll(line.substr(name.size() + 1));
  }
  return 0;
}

void read_one(const ReadTarget& target, const fs::path& path, Outcome& outcome) {
  std::ofstream("/proc/self/clear_refs") << "5";  // VmHWM starts anew
  const int64_t before = status_kib("VmRSS");
  const auto start = std::chrono::steady_clock::now();
  Outcome::State state = Outcome::wrong;
  try {
    state =
        read_checked(target, path) == ReadResult::accepted ? Outcome::accepted : Outcome::refused;
  } catch (const std::exception& error) {
    std::snprintf(outcome.message, sizeof(outcome.message), "%s", error.what());
  }
  outcome.ms =
      std::chrono::duration<float, std::milli>(std::chrono::steady_clock::now() - start).count();
  const auto size_kib = static_cast<int64_t>(fs::file_size(path) / 1024);
  outcome.grown_kib = std::max<int64_t>(0, status_kib("VmHWM") - before - 2 * size_kib);
  outcome.state = state;
}

/// What became of a target's files.
struct Tally {
  size_t files = 0;
  size_t accepted = 0;
  size_t refused = 0;
  size_t broken = 0;
  float most_ms = 0;
  int64_t most_kib = 0;
};

class Run {
 public:
  Run(const fs::path& seeds, size_t files) : seeds_(seeds), files_(files), folder_(seeds) {
    const size_t bytes = files_a_child * sizeof(Outcome);
    void* shared = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED) throw std::runtime_error("no shared memory");
    outcomes_ = static_cast<Outcome*>(shared);
  }

  Tally run(const ReadTarget& target) {
    Tally tally;
    std::vector<fs::path> seeds;
    for (const auto& entry : fs::directory_iterator(seeds_ / target.name))
      seeds.push_back(entry.path());
    std::ranges::sort(seeds);
    if (seeds.empty()) throw std::runtime_error(fmt::format("no seeds of {}", target.name));
    const size_t each = (files_ + seeds.size() - 1) / seeds.size();
    for (const fs::path& seed : seeds) {
      check_seed(target, seed);
      const Spoiler spoiler(bytes_of(seed));
      for (size_t first = 0; first < each; first += files_a_child) {
        run_batch(target, spoiler, first, std::min(each, first + files_a_child), each, tally);
      }
    }
    return tally;
  }

 private:
  /// Seeds are right. Nothing is read in this process: the libraries' threads would not outlive a
  /// fork.
  static void check_seed(const ReadTarget& target, const fs::path& seed) {
    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("cannot start a child");
    if (child == 0) {
      try {
        target.read(seed);
        _exit(0);
      } catch (const std::exception& error) {
        fmt::print(stderr, "{}\n", error.what());
        _exit(1);
      }
    }
    int status = 0;
    waitpid(child, &status, 0);
    if (status != 0) throw std::runtime_error(fmt::format("the seed {} is wrong", seed.string()));
  }

  void run_batch(const ReadTarget& target, const Spoiler& spoiler, size_t first, size_t end,
                 size_t count, Tally& tally) {
    std::memset(outcomes_, 0, files_a_child * sizeof(Outcome));
    for (size_t next = first; next < end;) {
      const fs::path path = folder_.file(target);
      const pid_t child = fork();
      if (child < 0) throw std::runtime_error("cannot start a child");
      if (child == 0) {
        if (std::freopen("/dev/null", "w", stderr) == nullptr) _exit(9);
        for (size_t i = next; i < end; ++i) {
          std::ofstream(path, std::ios::binary) << spoiler.spoil(i, count);
          Outcome& outcome = outcomes_[i - first];
          outcome.state = Outcome::begun;
          alarm(20);
          read_one(target, path, outcome);
        }
        _exit(0);
      }
      int status = 0;
      waitpid(child, &status, 0);
      next = end;
      if (status != 0) {  // the file that it died of, and what comes after it
        const auto* dead = std::find_if(outcomes_, outcomes_ + (end - first),
                                        [](const Outcome& o) { return o.state == Outcome::begun; });
        next = static_cast<size_t>(dead - outcomes_) + first + 1;
        if (next <= end) {
          outcomes_[next - 1 - first].state = Outcome::wrong;
          std::snprintf(outcomes_[next - 1 - first].message, sizeof(Outcome::message), "%s %d",
                        WIFSIGNALED(status) ? "signal" : "exit",
                        WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status));
        }
      }
      fs::remove(path);
    }
    for (size_t i = first; i < end; ++i)
      count_in(target, spoiler.spoil(i, count), outcomes_[i - first], tally);
  }

  void count_in(const ReadTarget& target, const Bytes& file, const Outcome& outcome, Tally& tally) {
    ++tally.files;
    tally.most_ms = std::max(tally.most_ms, outcome.ms);
    tally.most_kib = std::max(tally.most_kib, outcome.grown_kib);
    std::string fault;
    if (outcome.state == Outcome::accepted) {
      ++tally.accepted;
    } else if (outcome.state == Outcome::refused) {
      ++tally.refused;
    } else {
      fault = outcome.message;
    }
    if (outcome.ms > most_ms) fault = fmt::format("{:.0f} ms", outcome.ms);
    if (outcome.grown_kib > most_extra_kib) fault = fmt::format("{} MiB", outcome.grown_kib / 1024);
    if (fault.empty()) return;
    ++tally.broken;
    fs::create_directories(seeds_ / "broken");
    const fs::path kept =
        seeds_ / "broken" /
        fmt::format("{}_{:016x}{}", target.name, std::hash<Bytes>()(file), target.extension);
    std::ofstream(kept, std::ios::binary) << file;
    fmt::print(stderr, "{}: {}\n", kept.string(), fault);
  }

  fs::path seeds_;
  size_t files_;
  HostileFolder folder_;
  Outcome* outcomes_ = nullptr;
};

int run_all(int argc, char** argv) {
  const size_t files = argc > 2 ? std::stoul(argv[2]) : 10000;
  Run run(argv[1], files);
  size_t broken = 0;
  std::string rows;
  for (const ReadTarget& target : read_targets()) {
    const bool is_chosen = argc <= 3 || std::any_of(argv + 3, argv + argc, [&](const char* name) {
                             return target.name == name;
                           });
    if (!is_chosen) continue;
    const Tally t = run.run(target);
    broken += t.broken;
    rows += fmt::format(
        "{}\n    {{\"format\": \"{}\", \"files\": {}, \"read\": {}, \"refused\": {}, \"broken\": "
        "{}, "
        "\"most_ms\": {:.1f}, \"most_mib\": {}}}",
        rows.empty() ? "" : ",", target.name, t.files, t.accepted, t.refused, t.broken, t.most_ms,
        t.most_kib / 1024);
  }
  fmt::print("{{\n  \"schema\": \"relume-spoiled-1\",\n  \"rows\": [{}\n  ]\n}}\n", rows);
  return broken > 0 ? 1 : 0;
}

}  // namespace
}  // namespace relume::test

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: spoil_files SEEDS [FILES_A_FORMAT [TARGET...]]\n");
    return 2;
  }
  try {
    return relume::test::run_all(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "spoil_files: {}\n", error.what());
    return 2;
  }
}
