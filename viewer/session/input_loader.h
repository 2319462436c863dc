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
#include "viewer/session/load_status.h"
#include "viewer/session/prepare_preview.h"
#include "viewer/session/record_maker.h"
#include "viewer/session/session.h"
#include "viewer/session/session_file.h"

namespace relume {

/// What opening an input gives.
struct OpenedInput {
  std::unique_ptr<Session> session;
  /// Prepares the session's reference; takes long. Empty: there is none to be had.
  std::function<std::unique_ptr<FrameSource>(const ProgressCallback&)> make_reference;
  /// Prepares other records for the session. Empty: there are none to be had.
  RecordSource records;
};

/// Opens the scene or cache that a session names; runs on a thread of its own. Throws Error, of
/// kind cancelled soon after the callback returned false.
using InputOpener = std::function<OpenedInput(
    const SessionFile& session, const ProgressCallback& progress, PreparePreview& preview)>;

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
  RecordSource take_record_source();
  /// The tiles prepared so far, see PreparePreview::take().
  bool take_preview(Image& image, float& exposure) { return preview_.take(image, exposure); }
  const SessionFile& file() const { return file_; }
  /// Asks the work to end soon.
  void stop();
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
  RecordSource record_source_;
  std::exception_ptr failure_;

  std::thread thread_;  // last: starts when all else exists
};

}  // namespace relume
