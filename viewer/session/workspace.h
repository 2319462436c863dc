#pragma once

#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "viewer/session/background_writer.h"
#include "viewer/session/edit_history.h"
#include "viewer/session/input_loader.h"
#include "viewer/session/session.h"
#include "viewer/session/session_file.h"
#include "viewer/session/trade.h"

namespace relume {

struct WorkspaceOptions {
  /// For autosaved work, recent files and the lights of copied commands; empty: nothing is kept.
  std::filesystem::path state_folder;
  /// Where exported frames go that are not told where.
  std::filesystem::path work_folder = ".";
  /// How scenes are prepared that are opened by their own name, not through a session.
  PrepareOptions prepare{};
  uint64_t seed = 0;
};

/// A line for the person.
struct Notice {
  std::string text;  ///< empty = none
  bool is_problem = false;
};

/// What lasts while one session gives way to the next: which input and session file are open, the
/// history of edits, what is saved where, and the work that goes on in the background. Nothing
/// waits here but wait() and save(). Used from one thread. No user interface in it.
class Workspace {
 public:
  /// Around a session that is ready.
  explicit Workspace(std::unique_ptr<Session> session, SessionFile origin = {},
                     WorkspaceOptions options = {});
  /// Opens `input`, see open(); the session comes later.
  Workspace(InputOpener opener, const std::string& input, WorkspaceOptions options);
  ~Workspace();
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

  /// Counts the sessions shown so far: tells one from the next.
  uint64_t session_number() const { return session_number_; }
  /// The session that is shown, or null before the first one is there.
  Session* session() { return session_.get(); }
  const Session* session() const { return session_.get(); }

  /// Opens a built-in scene by its label, or a scene, cache or session file, or takes the lights
  /// from a file of lights; what is open stays until the new input is ready. A failure becomes a
  /// notice.
  void open(const std::string& input);

  /// Takes what is ready, makes undo steps and autosaves when `resting` (no edit is going on), and
  /// updates the session.
  void update(bool resting);
  /// update() until nothing is left to come.
  void wait(bool resting);

  void undo();
  void redo();
  const EditHistory& history() const { return history_; }

  /// The session file that save() writes to; empty = none yet.
  const std::filesystem::path& document() const { return document_; }
  /// There are edits that no session file holds.
  bool is_modified() const;
  /// Writes a session file, with ".json" where the name has no extension. False, with a notice,
  /// where that fails.
  bool save(const std::filesystem::path& path);

  /// Writes the picture that is shown, computed anew in the background, with a layer per light
  /// (.exr), or as displayed (.png).
  void export_frame(const std::filesystem::path& path);
  /// The same under a name that is free, in the work folder.
  void export_next_frame();
  /// See render_command(); writes the lights' file that the command names. Empty, with a notice,
  /// where that fails.
  std::string copy_command();

  /// The curve config can be shown.
  bool has_config_view() const { return config_problem_.empty(); }

  /// The last thing that happened, until the next edit.
  const Notice& notice() const { return notice_; }
  void set_notice(const std::string& text, bool is_problem = false);
  LoadStatus load_status() const;

  /// Other records can be prepared for the session.
  bool can_trade() const { return maker_ != nullptr; }
  /// What the view's trade has come to; nothing while that is not known, and by hand.
  const std::optional<TradePlan>& trade_plan() const { return plan_; }
  /// Records that the session goes on with; not set: as opened.
  const RecordChoice& records() const { return records_; }
  /// How far a forecast or other records are.
  LoadStatus trade_status() const;
  bool is_exporting() const { return exporting_.valid(); }
  /// The picture of a first load so far: changes version when it does.
  const Picture& preview() const { return preview_; }
  std::vector<std::string> recent_files() const;
  /// Input, options and view as a session file has them.
  SessionFile snapshot() const;

  /// `notify` is called, from any thread, when update() has something to take; empty: nobody is
  /// told. When this returns the previous function is not running and will not be called again.
  void set_notify(std::function<void()> notify);
  /// Throws what the first input failed with, when there is no session because of that.
  void require_session() const;

 private:
  /// What a plan was made for.
  struct Planned {
    Trade trade;
    bool has_shadows = true;
    bool operator==(const Planned&) const = default;
  };

  void open_session(SessionFile file, bool has_view, std::filesystem::path document);
  void take_loaded();
  void follow_trade(bool resting);
  static Planned planned_for(const ViewState& view);
  RecordChoice loaded_records() const;
  SessionFile origin_of_records() const;
  void plan_records();
  void take_records();
  /// Ends a load or a session, which may take long, in the background, one after the other.
  template <class... Parts>
  void retire(Parts... parts);
  void leave_session();
  void adopt(std::unique_ptr<Session> session);
  void restore_autosave();
  void choose_shown_curve(ViewState& view);
  void take_export();
  void autosave();
  void close_autosave();
  void paint_preview();
  void remove_autosave();
  std::filesystem::path autosave_path() const;
  WorkspaceOptions options_;
  InputOpener opener_;
  const std::string config_problem_;  ///< why the curve config cannot be shown; empty: it can
  std::future<void> draft_made_;      ///< of the curve config, before the first drag
  std::mutex notify_mutex_;           // held while notify_ runs
  std::function<void()> notify_;

  void tell();

  uint64_t session_number_ = 0;
  SessionFile origin_;  ///< of session_; its view is not used
  std::filesystem::path document_;
  EditHistory history_;
  size_t saved_step_ = 0;
  bool has_saved_step_ = true;  ///< a step with this number may be another one after an undo
  std::string autosaved_;       ///< what need not be autosaved (again)
  bool loaded_view_ = false;    ///< of the input being opened: its view is the session file's
  std::filesystem::path loaded_document_;
  Notice notice_;
  Picture preview_;

  BackgroundWriter writer_;
  RecordChoice records_;
  std::optional<FrameForecast> forecast_;  ///< of session_
  std::optional<Planned> planned_;
  std::optional<TradePlan> plan_;

  std::future<void> retired_;
  std::unique_ptr<Session> session_;
  std::unique_ptr<InputLoader> loader_;  // uses session_
  std::unique_ptr<RecordMaker> maker_;   // uses session_
  std::future<Notice> exporting_;        // uses session_
};

}  // namespace relume
