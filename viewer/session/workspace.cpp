#include "viewer/session/workspace.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/image/color_config.h"
#include "core/scene/io/load_scene.h"
#include "viewer/frames/frame_layers.h"
#include "viewer/session/recent_files.h"
#include "viewer/session/render_command.h"
#include "viewer/session/save_frame.h"

namespace relume {
namespace {

/// A built-in scene's label stays; a path becomes absolute, so that it means the same tomorrow.
std::string absolute_input(const std::string& input) {
  const std::vector<std::string> builtin = builtin_scene_names();
  if (std::find(builtin.begin(), builtin.end(), input) != builtin.end()) return input;
  return std::filesystem::absolute(input).lexically_normal().string();
}

bool is_json(const std::string& path) {
  return std::filesystem::path(path).extension() == ".json";
}

/// True for a text that holds lights and no scene.
bool is_light_file(const std::string& text) {
  return text.find("\"geometry\"") == std::string::npos &&
         text.find("\"lights\"") != std::string::npos;
}

/// Why $OCIO gives nothing to show pictures with; empty where it does.
std::string find_config_problem() {
  try {
    config_view();
  } catch (const Error& failure) {
    return printable(failure.what(), 400);
  }
  return {};
}

/// Makes what drafts of the curve config are read from, in the background.
std::future<void> make_draft() {
  return std::async(std::launch::async, [&view = config_view()] { view.table(); });
}

/// Everything that an export needs, apart from the session's own state.
struct FrameExport {
  const RelightCache* cache;
  const Tracer* tracer;
  std::vector<Light> lights;
  ShadowMethod shadows;
  DisplayTransform display;
  std::filesystem::path path;
};

Notice write_frame(const FrameExport& job) {
  try {
    const auto source = job.shadows == ShadowMethod::none || job.tracer == nullptr
                            ? nullptr
                            : make_shadow(job.shadows, *job.tracer, *job.cache);
    RelightState state = make_relight_state(*job.cache);
    relight(state, job.lights, source.get());
    save_frame(state, job.display, job.path,
               {.shadow = source ? job.shadows : ShadowMethod::none,
                .shadows = source.get(),
                .scene = source ? &job.tracer->scene() : nullptr});
  } catch (const std::exception& failure) {
    return {printable(failure.what(), 400), true};
  }
  return {fmt::format("wrote {}", job.path.string())};
}

}  // namespace

Workspace::Workspace(std::unique_ptr<Session> session, SessionFile origin, WorkspaceOptions options)
    : options_(std::move(options)),
      config_problem_(find_config_problem()),
      draft_made_(has_config_view() ? make_draft() : std::future<void>()),
      origin_(std::move(origin)) {
  adopt(std::move(session));
}

Workspace::Workspace(InputOpener opener, const std::string& input, WorkspaceOptions options)
    : options_(std::move(options)),
      opener_(std::move(opener)),
      config_problem_(find_config_problem()),
      draft_made_(has_config_view() ? make_draft() : std::future<void>()) {
  open(input);
}

Workspace::~Workspace() {
  maker_.reset();
  loader_.reset();
  if (retired_.valid()) retired_.wait();  // a former load may use the session
  leave_session();
}

template <class... Parts>
void Workspace::retire(Parts... parts) {
  // Parts go in the order given, after everything that was retired before.
  retired_ = std::async(std::launch::async,
                        [before = std::move(retired_), ... parts = std::move(parts)]() mutable {
                          if (before.valid()) before.wait();
                          (parts.reset(), ...);
                        });
}

void Workspace::set_notify(std::function<void()> notify) {
  const std::lock_guard lock(notify_mutex_);
  notify_ = std::move(notify);
}

void Workspace::tell() {
  const std::lock_guard lock(notify_mutex_);
  if (notify_) notify_();
}

void Workspace::require_session() const {
  if (!session_ && loader_) loader_->rethrow_failure();
}

void Workspace::open(const std::string& input) {
  try {
    SessionFile file;
    file.input = absolute_input(input);
    file.prepare = options_.prepare;
    file.seed = options_.seed;
    if (is_json(input)) {
      const std::string text = read_text_file(input, uint64_t{64} << 20);
      if (is_session(text)) {
        file = parse_session(text, input);
        open_session(std::move(file), true, absolute_input(input));
        return;
      }
      if (session_ && is_light_file(text)) {
        session_->view().lights = parse_lights(text, input);
        session_->view().solo_lights.clear();
        session_->view().selected_light = session_->view().lights.empty() ? -1 : 0;
        set_notice("took the lights of " + input);
        return;
      }
    }
    open_session(std::move(file), false, {});
  } catch (const std::exception& failure) {
    set_notice(printable(failure.what(), 400), true);
  }
}

void Workspace::open_session(SessionFile file, bool has_view, std::filesystem::path document) {
  if (!opener_) {
    set_notice("this window cannot open other inputs", true);
    return;
  }
  if (loader_) {
    loader_->stop();
    retire(std::move(loader_));
  }
  loaded_view_ = has_view;
  loaded_document_ = std::move(document);
  notice_ = {};
  preview_.rgba.clear();
  loader_ = std::make_unique<InputLoader>(opener_, std::move(file), [this] { tell(); });
}

void Workspace::take_loaded() {
  if (!loader_ || exporting_.valid()) return;  // an export uses what is open
  if (std::unique_ptr<Session> session = loader_->take_session()) {
    leave_session();
    if (maker_) maker_->stop();
    retire(std::move(maker_), std::move(session_));
    origin_ = loader_->file();
    document_ = loaded_document_;
    if (loaded_view_) session->view() = origin_.view;
    adopt(std::move(session));
    if (RecordSource source = loader_->take_record_source()) {
      maker_ = std::make_unique<RecordMaker>(std::move(source), [this] { tell(); });
    }
  }
  if (std::unique_ptr<FrameSource> reference = loader_->take_reference()) {
    session_->set_reference(std::move(reference));
  }
  const LoadStatus status = loader_->status();
  if (!status.problem.empty() && notice_.text != status.problem) set_notice(status.problem, true);
}

void Workspace::leave_session() {
  if (exporting_.valid()) exporting_.wait();
  take_export();
  if (session_) session_->set_notify({});
  close_autosave();
}

void Workspace::adopt(std::unique_ptr<Session> session) {
  session_ = std::move(session);
  ++session_number_;
  session_->set_notify([this] { tell(); });
  if (session_->cache() != nullptr) {
    origin_.prepare = chosen_options(origin_.prepare, session_->cache()->info());
  }
  records_ = loaded_records();
  forecast_.reset();
  plan_.reset();
  // Records that a session file holds stay as they are until the trade is changed.
  planned_.reset();
  if (records_.is_set()) planned_ = planned_for(session_->view());
  choose_shown_curve(session_->view());
  history_.reset(session_->view());
  saved_step_ = 0;
  has_saved_step_ = true;
  autosaved_ = format_session(snapshot());
  restore_autosave();
  if (!origin_.input.empty()) {
    add_recent_file(options_.state_folder, document_.empty() ? origin_.input : document_.string());
  }
}

/// Gives srgb where the configuration is not there that a session, or this window, shows.
void Workspace::choose_shown_curve(ViewState& view) {
  if (view.display.curve != ToneCurve::config || has_config_view()) return;
  view.display.curve = ToneCurve::srgb;
  set_notice("shown with the curve srgb: " + config_problem_, true);
}

std::filesystem::path Workspace::autosave_path() const {
  return autosave_file(options_.state_folder,
                       document_.empty() ? origin_.input : document_.string());
}

void Workspace::restore_autosave() {
  if (options_.state_folder.empty()) return;
  const std::filesystem::path path = autosave_path();
  std::error_code missing;
  if (!std::filesystem::exists(path, missing)) return;
  try {
    const SessionFile saved = parse_session(read_text_file(path, max_session_bytes), path.string());
    if (saved.input != origin_.input) return;
    session_->view() = saved.view;
    choose_shown_curve(session_->view());
    if (history_.commit(session_->view())) {
      set_notice("restored the work that was not saved;  ctrl+z goes back");
    }
  } catch (const Error& failure) {
    set_notice(printable(failure.what(), 400), true);
  }
}

void Workspace::update(bool resting) {
  take_loaded();
  take_export();
  paint_preview();
  if (!session_) return;
  if (resting && history_.commit(session_->view())) {
    notice_ = {};
    // An undo and another edit lead to the same number of steps.
    if (history_.step_count() <= saved_step_) has_saved_step_ = false;
  }
  if (resting) autosave();
  follow_trade(resting);
  session_->update(resting);
  // The reference can wait, a drag and the first frame cannot.
  const bool is_urgent = !resting || session_->status().busy || session_->picture().version == 0;
  const bool is_forecasting = maker_ && maker_->is_forecasting();
  if (loader_ && loader_->status().working) loader_->set_paused(is_urgent || is_forecasting);
  if (maker_ && maker_->status().working) maker_->set_paused(is_urgent);
}

Workspace::Planned Workspace::planned_for(const ViewState& view) {
  return {view.trade, view.shadows != ShadowMethod::none};
}

/// What the session was opened with, where it is what its view asks for.
RecordChoice Workspace::loaded_records() const {
  const SessionInfo& info = session_->info();
  const RecordChoice opened{info.budget.average_records, info.format};
  return opened == session_->view().records ? opened : RecordChoice{};
}

/// Records follow the trade, or what undoing brought back, when nothing is being dragged.
void Workspace::follow_trade(bool resting) {
  if (!maker_) return;
  if (auto forecast = maker_->take_forecast()) forecast_ = std::move(forecast);
  if (const std::string problem = maker_->take_problem(); !problem.empty()) {
    set_notice(problem, true);
    // What cannot be measured now is not tried again before the trade changes.
    if (!forecast_) planned_ = planned_for(session_->view());
  }
  plan_records();
  take_records();
  if (!resting) return;
  const RecordChoice& wanted = session_->view().records;
  if (wanted == records_) {
    maker_->withdraw_records();
  } else {
    maker_->ask_records(wanted, plan_ && plan_->records == wanted ? plan_->record_cost : 0);
  }
}

void Workspace::plan_records() {
  ViewState& view = session_->view();
  const Planned wanted = planned_for(view);
  if (view.trade.kind == TradeKind::manual) {
    planned_ = wanted;
    plan_.reset();
  } else if (planned_ != wanted) {
    if (!forecast_) return maker_->ask_forecast();
    plan_ = plan_trade(view.trade, *forecast_, wanted.has_shadows);
    view.records = plan_->records;
    planned_ = wanted;
  }
}

void Workspace::take_records() {
  if (exporting_.valid()) return;  // it uses those that are there
  std::optional<RecordMaker::Made> made = maker_->take_records();
  if (!made) return;
  session_->set_records(std::move(made->records));
  records_ = made->choice;
}

LoadStatus Workspace::trade_status() const {
  return maker_ ? maker_->status() : LoadStatus{};
}

void Workspace::wait(bool resting) {
  if (exporting_.valid()) exporting_.wait();
  if (loader_) loader_->wait();
  update(resting);
  // A forecast is followed by a plan, a plan by its records.
  while (maker_ && maker_->is_busy()) {
    maker_->wait();
    update(resting);
  }
  if (session_) session_->wait(resting);
  if (retired_.valid()) retired_.wait();
  writer_.wait();
}

void Workspace::undo() {
  if (!session_) return;
  if (!history_.undo(session_->view())) set_notice("nothing to undo");
}

void Workspace::redo() {
  if (!session_) return;
  if (!history_.redo(session_->view())) set_notice("nothing to redo");
}

bool Workspace::is_modified() const {
  return !has_saved_step_ || history_.step_count() != saved_step_;
}

SessionFile Workspace::snapshot() const {
  SessionFile file = origin_;
  if (session_) file.view = session_->view();
  return file;
}

bool Workspace::save(const std::filesystem::path& path) {
  if (!session_) return false;
  try {
    std::filesystem::path target = std::filesystem::absolute(path).lexically_normal();
    if (target.extension().empty()) target += ".json";
    write_file_atomic(target, format_session(snapshot()));
    history_.commit(session_->view());
    remove_autosave();
    document_ = target;
    saved_step_ = history_.step_count();
    has_saved_step_ = true;
    autosaved_ = format_session(snapshot());
    add_recent_file(options_.state_folder, document_.string());
    set_notice("saved " + document_.string());
    return true;
  } catch (const std::exception& failure) {
    set_notice(printable(failure.what(), 400), true);
    return false;
  }
}

void Workspace::autosave() {
  if (options_.state_folder.empty()) return;
  std::string text = format_session(snapshot());
  if (text == autosaved_) return;
  autosaved_ = text;
  writer_.write(autosave_path(), std::move(text));
}

/// Nothing is lost by leaving: what is not saved becomes the last session, among the recent files.
void Workspace::close_autosave() {
  if (options_.state_folder.empty() || !session_) return;
  if (is_modified()) {
    const std::filesystem::path last = options_.state_folder / "last-session.json";
    writer_.write(last, format_session(snapshot()));
    add_recent_file(options_.state_folder, last.string());
  }
  remove_autosave();
}

void Workspace::remove_autosave() {
  if (!options_.state_folder.empty()) writer_.remove(autosave_path());
}

void Workspace::export_frame(const std::filesystem::path& path) {
  if (!session_ || session_->cache() == nullptr) {
    set_notice("there is no frame to export", true);
    return;
  }
  if (exporting_.valid()) {
    set_notice("a frame is still being written", true);
    return;
  }
  const bool all_samples = shows_all_samples(*session_);
  FrameExport job{all_samples ? session_->reference_cache() : session_->cache(),
                  session_->tracer(),
                  shown_lights(session_->view()),
                  all_samples ? ShadowMethod::ray : session_->view().shadows,
                  session_->view().display,
                  std::filesystem::absolute(path).lexically_normal()};
  set_notice("writing " + job.path.string());
  exporting_ = std::async(std::launch::async, [this, job = std::move(job)] {
    const Notice notice = write_frame(job);
    tell();
    return notice;
  });
}

void Workspace::export_next_frame() {
  std::string stem = session_ ? printable(session_->info().title, 80) : "frame";
  std::replace(stem.begin(), stem.end(), '/', '_');
  std::filesystem::path path;
  std::error_code unreadable;
  int number = 1;
  do {
    path = options_.work_folder / fmt::format("{}-{:03}.exr", stem, number++);
  } while (std::filesystem::exists(path, unreadable));
  export_frame(path);
}

void Workspace::take_export() {
  using namespace std::chrono_literals;
  if (!exporting_.valid() || exporting_.wait_for(0s) != std::future_status::ready) return;
  notice_ = exporting_.get();
}

/// What gives the records that are shown: a cache's own are in it, others come from its scene.
SessionFile Workspace::origin_of_records() const {
  SessionFile origin = origin_;
  if (!records_.is_set() || session_->cache() == nullptr) return origin;
  const CacheInfo& info = session_->cache()->info();
  if (std::filesystem::path(origin.input).extension() == ".relume") {
    origin.input = scene_input(info);
    origin.prepare = options_of(info).value_or(origin.prepare);
    origin.seed = info.seed;
  }
  origin.prepare = with_records(origin.prepare, records_);
  return origin;
}

std::string Workspace::copy_command() {
  if (!session_) return {};
  try {
    const std::string text = format_lights(shown_lights(session_->view()));
    const std::filesystem::path folder =
        options_.state_folder.empty() ? options_.work_folder : options_.state_folder;
    make_folder(folder);
    const std::filesystem::path lights = lights_file(folder, text);
    write_file_atomic(lights, text);
    set_notice("copied the command that renders this picture");
    return render_command(origin_of_records(), *session_, absolute_input(lights.string()),
                          "frame.exr");
  } catch (const std::exception& failure) {
    set_notice(printable(failure.what(), 400), true);
    return {};
  }
}

void Workspace::set_notice(const std::string& text, bool is_problem) {
  notice_ = {text, is_problem};
}

LoadStatus Workspace::load_status() const {
  return loader_ ? loader_->status() : LoadStatus{};
}

std::vector<std::string> Workspace::recent_files() const {
  return read_recent_files(options_.state_folder);
}

void Workspace::paint_preview() {
  if (!loader_ || session_) return;
  Image image;
  DisplayTransform display{.curve = default_curve()};
  if (!loader_->take_preview(image, display.exposure)) return;
  preview_.width = image.width;
  preview_.height = image.height;
  preview_.rgba.resize(4 * image.pixel_count());
  if (loaded_view_) display = loader_->file().view.display;
  if (display.curve == ToneCurve::config && !has_config_view()) display.curve = ToneCurve::srgb;
  apply_display_rgba(image, display, preview_.rgba);
  ++preview_.version;
}

}  // namespace relume
