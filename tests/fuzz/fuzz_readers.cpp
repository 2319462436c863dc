// libFuzzer's entry: RELUME_FUZZ_TARGET names the reader (tests/fuzz/read_targets.h),
// RELUME_FUZZ_SEEDS the folder of right files (tests/fuzz/make_seeds). `./dev fuzz` runs it for
// each.

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <memory>

#include "tests/fuzz/read_targets.h"

namespace {

using namespace relume::test;  // NOLINT: the targets

const ReadTarget* target = nullptr;
// Readers take files: one in memory, rewritten for each input.
std::unique_ptr<HostileFolder> folder;
std::string path;
// What readers tell of each file is not kept (-close_fd_mask): a line a million times.
int findings = STDERR_FILENO;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  if (*argc == 2 && std::string_view((*argv)[1]) == "--list") {
    for (const ReadTarget& one : read_targets()) {
      if (!one.is_decoded_outside) fmt::print("{}\n", one.name);
    }
    std::exit(0);
  }
  const char* name = std::getenv("RELUME_FUZZ_TARGET");
  target = find_read_target(name != nullptr ? name : "");
  if (target == nullptr) {
    fmt::print(stderr, "RELUME_FUZZ_TARGET is none of:");
    for (const ReadTarget& one : read_targets()) fmt::print(stderr, " {}", one.name);
    fmt::print(stderr, "\n");
    std::exit(2);
  }
  const char* seeds = std::getenv("RELUME_FUZZ_SEEDS");
  folder = std::make_unique<HostileFolder>(seeds != nullptr ? seeds : "");
  path = folder->file(*target).string();
  std::atexit([] { folder.reset(); });
  findings = dup(STDERR_FILENO);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const int file = open(path.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600);
  if (file < 0 || write(file, data, size) != static_cast<ssize_t>(size)) std::abort();
  close(file);
  try {
    read_checked(*target, path);
  } catch (const std::exception& error) {
    dprintf(findings, "%s\n", fmt::format("{}: {}", target->name, error.what()).c_str());
    std::abort();
  }
  return 0;
}
