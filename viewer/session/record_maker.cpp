#include "viewer/session/record_maker.h"

#include <exception>
#include <new>
#include <utility>

#include "core/base/error.h"

namespace relume {

RecordMaker::RecordMaker(RecordSource source, std::function<void()> notify)
    : source_(std::move(source)), notify_(std::move(notify)), thread_([this] { run(); }) {}

RecordMaker::~RecordMaker() {
  stop();
  thread_.join();
}

void RecordMaker::stop() {
  {
    const std::lock_guard lock(mutex_);
    quit_ = true;
  }
  wake_.notify_all();
}

void RecordMaker::ask_forecast() {
  {
    const std::lock_guard lock(mutex_);
    if (forecast_asked_ || forecasting_) return;
    forecast_asked_ = true;
    cancelled_ = true;
  }
  wake_.notify_all();
}

void RecordMaker::ask_records(const RecordChoice& choice, float record_cost) {
  {
    const std::lock_guard lock(mutex_);
    if (asked_ == choice) return;
    asked_ = choice;
    next_ = Order{choice, record_cost};
    made_.reset();
    cancelled_ = true;
  }
  wake_.notify_all();
}

void RecordMaker::withdraw_records() {
  {
    const std::lock_guard lock(mutex_);
    asked_.reset();
    next_.reset();
    made_.reset();
    cancelled_ = true;
  }
  wake_.notify_all();
}

std::optional<FrameForecast> RecordMaker::take_forecast() {
  const std::lock_guard lock(mutex_);
  return std::exchange(forecast_, std::nullopt);
}

std::optional<RecordMaker::Made> RecordMaker::take_records() {
  const std::lock_guard lock(mutex_);
  return std::exchange(made_, std::nullopt);
}

std::string RecordMaker::take_problem() {
  const std::lock_guard lock(mutex_);
  return std::exchange(problem_, {});
}

LoadStatus RecordMaker::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

bool RecordMaker::is_forecasting() const {
  const std::lock_guard lock(mutex_);
  return forecasting_ || forecast_asked_;
}

bool RecordMaker::is_busy() const {
  const std::lock_guard lock(mutex_);
  return running_ || has_work() || forecast_ || made_ || !problem_.empty();
}

void RecordMaker::set_paused(bool paused) {
  {
    const std::lock_guard lock(mutex_);
    paused_ = paused;
  }
  wake_.notify_all();
}

void RecordMaker::wait() {
  set_paused(false);
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [this] { return !running_ && !has_work(); });
}

void RecordMaker::run() {
  for (;;) {
    std::optional<Order> order;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return quit_ || has_work(); });
      if (quit_) return;
      running_ = true;
      cancelled_ = false;
      forecasting_ = std::exchange(forecast_asked_, false);
      if (!forecasting_) order = std::exchange(next_, std::nullopt);
      status_ = {};
      status_.working = true;
    }
    std::string problem = work(order);
    {
      const std::lock_guard lock(mutex_);
      // A forecast that came while records were under way has taken their place.
      if (order && cancelled_ && !next_ && asked_ == order->choice) next_ = order;
      status_ = {};
      if (!quit_ && (forecasting_ || !cancelled_)) problem_ = std::move(problem);
      running_ = false;
      forecasting_ = false;
    }
    idle_.notify_all();
    if (notify_) notify_();
  }
}

std::string RecordMaker::work(std::optional<Order> order) {
  const ProgressCallback progress = [this](const std::string& stage, double fraction,
                                           double seconds_left) {
    return report(stage, fraction, seconds_left);
  };
  try {
    if (order) {
      SessionRecords records = source_.prepare(order->choice, order->record_cost, progress);
      const std::lock_guard lock(mutex_);
      if (!cancelled_) made_ = Made{order->choice, std::move(records)};
    } else {
      FrameForecast forecast = source_.forecast(progress);
      const std::lock_guard lock(mutex_);
      forecast_ = std::move(forecast);
    }
  } catch (const std::bad_alloc&) {
    return "preparing other records ran out of memory; close other programs";
  } catch (const std::exception& failure) {
    return printable(failure.what(), 400);
  }
  return {};
}

bool RecordMaker::report(const std::string& stage, double fraction, double seconds_left) {
  {
    const std::lock_guard lock(mutex_);
    status_.stage = stage;
    status_.fraction = fraction;
    status_.seconds_left = seconds_left;
  }
  if (notify_) notify_();
  std::unique_lock lock(mutex_);
  const auto is_given_up = [this] { return quit_ || (cancelled_ && !forecasting_); };
  wake_.wait(lock, [&] { return !paused_ || is_given_up(); });
  return !is_given_up() && !interrupted();
}

}  // namespace relume
