#include "viewer/session/relight_worker.h"

#include <exception>
#include <new>
#include <utility>

#include "core/base/error.h"
#include "core/base/timer.h"

namespace relume {

RelightWorker::RelightWorker(std::unique_ptr<FrameSource> source)
    : source_(std::move(source)), thread_([this] { run(); }) {}

RelightWorker::~RelightWorker() {
  {
    const std::lock_guard lock(mutex_);
    quit_ = true;
    if (running_may_stop_) cancelled_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void RelightWorker::submit(RelightRequest request) {
  {
    const std::lock_guard lock(mutex_);
    ++counts_.submitted;
    if (next_) ++counts_.superseded;
    next_ = std::move(request);
    if (running_may_stop_) cancelled_ = true;
  }
  wake_.notify_one();
}

void RelightWorker::stop() {
  const std::lock_guard lock(mutex_);
  if (next_) ++counts_.superseded;
  next_.reset();
  if (running_may_stop_) cancelled_ = true;
}

bool RelightWorker::take(RelitFrame& frame) {
  const std::lock_guard lock(mutex_);
  if (!fresh_) return false;
  std::swap(frame, newest_);
  fresh_ = false;
  return true;
}

bool RelightWorker::busy() const {
  const std::lock_guard lock(mutex_);
  return running_ || next_.has_value();
}

void RelightWorker::wait_idle() const {
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [this] { return !running_ && !next_; });
}

void RelightWorker::set_notify(std::function<void()> notify) {
  const std::lock_guard lock(notify_mutex_);
  notify_ = std::move(notify);
}

WorkerCounts RelightWorker::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void RelightWorker::run() {
  RelitFrame frame;
  for (;;) {
    RelightRequest request;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return quit_ || next_; });
      if (quit_) return;
      request = std::move(*next_);
      next_.reset();
      running_ = true;
      running_may_stop_ = request.may_stop;
      cancelled_ = false;
    }
    const bool is_picture = compute(std::move(request), frame);
    {
      const std::lock_guard lock(mutex_);
      if (is_picture) {
        std::swap(frame, newest_);
        fresh_ = true;
      }
      running_ = false;
      running_may_stop_ = false;
      ++(is_picture ? counts_.finished : counts_.stopped);
    }
    idle_.notify_all();
    const std::lock_guard lock(notify_mutex_);
    if (notify_) notify_();
  }
}

bool RelightWorker::compute(RelightRequest request, RelitFrame& frame) {
  const Timer timer;
  frame.request = std::move(request);
  frame.error.clear();
  frame.stats = {};
  frame.work = {};
  try {
    source_->render(frame.request, cancelled_, frame);
  } catch (const std::bad_alloc&) {
    frame.error = "relighting ran out of memory; close other programs or prepare fewer records";
  } catch (const Error& failure) {
    if (failure.kind() == ErrorKind::cancelled && cancelled_) return false;
    frame.error = printable(failure.what());
  } catch (const std::exception& failure) {
    frame.error = printable(failure.what());
  } catch (...) {
    frame.error = "relighting failed for an unknown reason";
  }
  frame.ms = timer.ms();
  return true;
}

}  // namespace relume
