#include "viewer/session/background_writer.h"

#include <exception>
#include <utility>

#include "core/base/error.h"
#include "core/base/file.h"

namespace relume {

BackgroundWriter::BackgroundWriter() : thread_([this] { run(); }) {}

BackgroundWriter::~BackgroundWriter() {
  {
    const std::lock_guard lock(mutex_);
    quit_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void BackgroundWriter::write(std::filesystem::path path, std::string text) {
  submit({std::move(path), std::move(text)});
}

void BackgroundWriter::remove(std::filesystem::path path) {
  submit({std::move(path), std::nullopt});
}

void BackgroundWriter::submit(Task task) {
  {
    std::unique_lock lock(mutex_);
    // Work on another file is not replaced.
    idle_.wait(lock, [&] { return !next_ || next_->path == task.path; });
    next_ = std::move(task);
  }
  wake_.notify_one();
}

void BackgroundWriter::wait() {
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [this] { return !running_ && !next_; });
}

std::string BackgroundWriter::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

void BackgroundWriter::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return quit_ || next_; });
    if (!next_) return;
    const Task task = std::move(*next_);
    next_.reset();
    running_ = true;
    idle_.notify_all();
    lock.unlock();
    std::string problem = perform(task);
    lock.lock();
    problem_ = std::move(problem);
    running_ = false;
    idle_.notify_all();
  }
}

std::string BackgroundWriter::perform(const Task& task) {
  try {
    if (task.text) {
      make_folder(task.path.parent_path());
      write_file_atomic(task.path, *task.text);
    } else {
      std::error_code missing;
      std::filesystem::remove(task.path, missing);
    }
  } catch (const std::exception& failure) {
    return printable(failure.what());
  }
  return {};
}

}  // namespace relume
