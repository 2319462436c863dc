#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "core/base/progress.h"
#include "viewer/session/prepare_preview.h"
#include "viewer/session/session.h"
#include "viewer/session/session_file.h"

namespace relume {

/// What opening an input gives.
struct OpenedInput {
  std::unique_ptr<Session> session;
  /// Prepares the session's reference; takes long. Empty: there is none to be had.
  std::function<std::unique_ptr<FrameSource>(const ProgressCallback&)> make_reference;
};

/// Opens the scene or cache that a session names; runs on a thread of its own. Throws Error, of
/// kind cancelled soon after the callback returned false.
using InputOpener = std::function<OpenedInput(
    const SessionFile& session, const ProgressCallback& progress, PreparePreview& preview)>;

/// How far a load is.
struct LoadStatus {
  std::string input;
  std::string stage;         ///< what is being done, for instance "prepare hair"
  double fraction = 0;       ///< of the stage, in [0, 1]
  double seconds_left = -1;  ///< < 0: unknown
  bool opening = false;      ///< the session is not there yet
  bool working = false;      ///< the session or its reference is being prepared
  std::string problem;       ///< why it failed, one line; empty = it did not
};

/// Opens one input in the background: first the session, so that work can begin, then its
/// reference. The destructor asks the work to stop and waits for it. The session must outlive the
/// loader. Used from one thread, `notify` aside.
class InputLoader {
 public:
  /// `notify` is called from the loader's thread when there is something to take or to say; it may
  /// be empty.
  InputLoader(InputOpener opener, SessionFile file, std::function<void()> notify);
  ~InputLoader();
  InputLoader(const InputLoader&) = delete;
  InputLoader& operator=(const InputLoader&) = delete;

  LoadStatus status() const;
  /// What was taken once is null from then on.
  std::unique_ptr<Session> take_session();
  std::unique_ptr<FrameSource> take_reference();
  /// The tiles prepared so far, see PreparePreview::take().
  bool take_preview(Image& image) { return preview_.take(image); }
  const SessionFile& file() const { return file_; }
  /// While true the work stands still where it next reports, so that what a person waits for gets
  /// the processors.
  void set_paused(bool paused);
  /// Blocks until everything is there or failed. Ends a pause.
  void wait();
  /// Throws what opening failed with, if it did.
  void rethrow_failure() const;

 private:
  void run();
  void open_all();
  bool report(const std::string& stage, double fraction, double seconds_left);
  void tell() const;

  const InputOpener opener_;
  const SessionFile file_;
  const std::function<void()> notify_;
  PreparePreview preview_;
  std::atomic<bool> stopped_{false};

  mutable std::mutex mutex_;  // guards the members below
  std::condition_variable resume_;
  bool paused_ = false;
  LoadStatus status_;
  std::unique_ptr<Session> session_;
  std::unique_ptr<FrameSource> reference_;
  std::exception_ptr failure_;

  std::thread thread_;  // last: starts when all else exists
};

}  // namespace relume
