#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "viewer/session/frame_source.h"

namespace relume {

/// What a worker did since it was made.
struct WorkerCounts {
  uint64_t submitted = 0;
  uint64_t superseded = 0;  ///< requests replaced before they were started
  uint64_t finished = 0;    ///< frames computed, failed ones included
  uint64_t stopped = 0;     ///< frames that a newer request or stop() ended unfinished
};

/// Computes frames on a thread of its own. There is one slot for the next request and one for the
/// newest frame: submitting replaces a request not yet started. A frame once started is finished,
/// unless it may stop: so a stream of requests faster than the source neither queues up nor
/// starves. A failing source yields a frame that carries the error. The destructor finishes the
/// running frame, unless it may stop, and joins. All members may be called from any thread.
class RelightWorker {
 public:
  explicit RelightWorker(std::unique_ptr<FrameSource> source);
  ~RelightWorker();
  RelightWorker(const RelightWorker&) = delete;
  RelightWorker& operator=(const RelightWorker&) = delete;

  void submit(RelightRequest request);

  /// Drops the waiting request, and ends the running one if it may stop.
  void stop();

  /// Swaps the newest frame into `frame`, whose old buffers are used again; false when none is new.
  bool take(RelitFrame& frame);

  /// True while a request waits or runs.
  bool busy() const;

  /// Blocks until nothing waits or runs; the newest frame can then be taken.
  void wait_idle() const;

  /// `notify` is called on the worker's thread after each frame; empty: nobody is told. When this
  /// returns the previous function is not running and will not be called again.
  void set_notify(std::function<void()> notify);

  WorkerCounts counts() const;

 private:
  void run();
  /// False when it was stopped: `frame` is then no picture.
  bool compute(RelightRequest request, RelitFrame& frame);

  std::unique_ptr<FrameSource> source_;
  std::atomic<bool> cancelled_{false};

  mutable std::mutex mutex_;  // guards the members below
  std::condition_variable wake_;
  mutable std::condition_variable idle_;
  std::optional<RelightRequest> next_;
  RelitFrame newest_;
  bool fresh_ = false;
  bool running_ = false;
  bool running_may_stop_ = false;
  bool quit_ = false;
  WorkerCounts counts_;

  std::mutex notify_mutex_;  // held while notify_ runs
  std::function<void()> notify_;

  std::thread thread_;  // last: starts when all else exists
};

}  // namespace relume
