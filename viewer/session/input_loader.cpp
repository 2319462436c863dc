#include "viewer/session/input_loader.h"

#include <exception>
#include <new>
#include <utility>

#include "core/base/error.h"

namespace relume {
namespace {

LoadStatus start_status(const SessionFile& file) {
  LoadStatus status;
  status.input = file.input;
  status.opening = true;
  status.working = true;
  return status;
}

}  // namespace

InputLoader::InputLoader(InputOpener opener, SessionFile file, std::function<void()> notify)
    : opener_(std::move(opener)),
      file_(std::move(file)),
      notify_(std::move(notify)),
      preview_([this] { tell(); }),
      status_(start_status(file_)),
      thread_([this] { run(); }) {}

void InputLoader::stop() {
  stopped_ = true;
  set_paused(false);
}

InputLoader::~InputLoader() {
  stop();
  if (thread_.joinable()) thread_.join();
}

LoadStatus InputLoader::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

std::unique_ptr<Session> InputLoader::take_session() {
  const std::lock_guard lock(mutex_);
  return std::move(session_);
}

std::unique_ptr<FrameSource> InputLoader::take_reference() {
  const std::lock_guard lock(mutex_);
  return std::move(reference_);
}

RecordSource InputLoader::take_record_source() {
  const std::lock_guard lock(mutex_);
  return std::move(record_source_);
}

void InputLoader::set_paused(bool paused) {
  {
    const std::lock_guard lock(mutex_);
    paused_ = paused;
  }
  resume_.notify_all();
}

void InputLoader::wait() {
  set_paused(false);
  if (thread_.joinable()) thread_.join();
}

void InputLoader::rethrow_failure() const {
  const std::lock_guard lock(mutex_);
  if (failure_) std::rethrow_exception(failure_);
}

void InputLoader::run() {
  std::string problem;
  std::exception_ptr thrown;
  try {
    open_all();
  } catch (const std::bad_alloc&) {
    problem = "opening ran out of memory; close other programs or prepare fewer records";
    thrown = std::current_exception();
  } catch (const std::exception& failure) {
    problem = stopped_ ? "" : printable(failure.what(), 400);
    thrown = std::current_exception();
  }
  {
    const std::lock_guard lock(mutex_);
    failure_ = thrown;
    status_.problem = problem;
    status_.opening = false;
    status_.working = false;
  }
  tell();
}

void InputLoader::open_all() {
  const ProgressCallback progress = [this](const std::string& stage, double fraction,
                                           double seconds_left) {
    return report(stage, fraction, seconds_left);
  };
  OpenedInput opened = opener_(file_, progress, preview_);
  {
    const std::lock_guard lock(mutex_);
    session_ = std::move(opened.session);
    record_source_ = std::move(opened.records);
    status_.opening = false;
  }
  tell();
  if (!opened.make_reference || stopped_) return;
  std::unique_ptr<FrameSource> reference = opened.make_reference(progress);
  const std::lock_guard lock(mutex_);
  reference_ = std::move(reference);
}

bool InputLoader::report(const std::string& stage, double fraction, double seconds_left) {
  {
    const std::lock_guard lock(mutex_);
    status_.stage = stage;
    status_.fraction = fraction;
    status_.seconds_left = seconds_left;
  }
  tell();
  std::unique_lock lock(mutex_);
  resume_.wait(lock, [this] { return !paused_ || stopped_; });
  return !stopped_ && !interrupted();
}

void InputLoader::tell() const {
  if (notify_) notify_();
}

}  // namespace relume
