#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/base/progress.h"
#include "viewer/session/frame_planning.h"
#include "viewer/session/load_status.h"
#include "viewer/session/session.h"

namespace relume {

/// Prepares the scene of an open session again, with other records. Both may throw Error, of kind
/// cancelled soon after the callback returned false; run on a thread of their own.
struct RecordSource {
  std::function<FrameForecast(const ProgressCallback& progress)> forecast;
  /// `record_cost` as in PrepareParams. A choice that is not set: what was opened.
  std::function<SessionRecords(const RecordChoice& choice, float record_cost,
                               const ProgressCallback& progress)>
      prepare;
  explicit operator bool() const { return forecast && prepare; }
};

/// Forecasts and prepares in the background. Records asked for last win: others under way are
/// given up. The destructor asks the work to stop and waits for it. Used from one thread, `notify`
/// aside.
class RecordMaker {
 public:
  /// `notify` is called from the maker's thread when there is something to take or to say.
  RecordMaker(RecordSource source, std::function<void()> notify);
  ~RecordMaker();
  RecordMaker(const RecordMaker&) = delete;
  RecordMaker& operator=(const RecordMaker&) = delete;

  /// Once is enough. Runs before any records.
  void ask_forecast();
  /// Does nothing where these are what was asked for last, even where that failed.
  void ask_records(const RecordChoice& choice, float record_cost);
  /// What is asked for or under way is not wanted any more.
  void withdraw_records();

  struct Made {
    RecordChoice choice;
    SessionRecords records;
  };
  /// What was taken once is gone from then on.
  std::optional<FrameForecast> take_forecast();
  std::optional<Made> take_records();

  /// Why the last work failed, one line; empty = it did not, or was told before.
  std::string take_problem();

  LoadStatus status() const;
  /// True while a forecast is asked for or under way: its times need the processors.
  bool is_forecasting() const;
  /// Something is asked for, under way or there to be taken.
  bool is_busy() const;
  /// Asks the work to end soon; nothing comes any more.
  void stop();
  /// See InputLoader::set_paused().
  void set_paused(bool paused);
  /// Blocks until all that was asked for is there or failed. Ends a pause.
  void wait();

 private:
  struct Order {
    RecordChoice choice;
    float record_cost = 0;
  };

  void run();
  /// The next thing to do; what it threw, one line.
  std::string work(std::optional<Order> order);
  bool report(const std::string& stage, double fraction, double seconds_left);
  bool has_work() const { return forecast_asked_ || next_.has_value(); }

  const RecordSource source_;
  const std::function<void()> notify_;

  mutable std::mutex mutex_;  // guards the members below
  std::condition_variable wake_;
  std::condition_variable idle_;
  std::optional<RecordChoice> asked_;
  std::optional<Order> next_;
  bool forecast_asked_ = false;
  bool forecasting_ = false;
  bool running_ = false;
  bool cancelled_ = false;  ///< the records under way
  bool paused_ = false;
  bool quit_ = false;
  std::optional<FrameForecast> forecast_;
  std::optional<Made> made_;
  std::string problem_;
  LoadStatus status_;

  std::thread thread_;  // last: starts when all else exists
};

}  // namespace relume
