#pragma once

#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/image/metrics.h"
#include "core/scene/scene.h"
#include "reduction/budget.h"
#include "viewer/session/frame_budget.h"
#include "viewer/session/relight_worker.h"
#include "viewer/session/view_state.h"

namespace relume {

/// What never changes while a session is open.
struct SessionInfo {
  std::string title;  ///< the scene's name
  int width = 0;      ///< pixels
  int height = 0;     ///< pixels
  Camera camera;
  Bounds bounds;       ///< of the scene, world
  std::string method;  ///< reduction label
  CacheFormat format = CacheFormat::exact;
  int records = 0;      ///< k asked for per pixel, at most
  RecordBudget budget;  ///< if any, that the records were shared out by
  int spp = 0;
  uint64_t record_count = 0;
  std::vector<float> coverage;         ///< per pixel in [0, 1]; empty = unknown
  std::vector<float> predicted_error;  ///< per pixel, see RelightCache; empty = the cache has none
  std::vector<float> record_counts;    ///< per pixel, see RelightCache
  bool can_trace = false;              ///< traced shadows are available
  bool has_members = false;            ///< shadow rays from members are, too
  bool has_reference = false;
  double predicted_mean = 0;  ///< of predicted_error over covered pixels
};

/// An 8-bit RGBA picture ready for the screen, rows top to bottom.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<uint8_t> rgba;  ///< 4 * width * height; empty before the first frame
  uint64_t version = 0;       ///< grows whenever the pixels change
};

/// Records in place of those that a session was opened with.
struct SessionRecords {
  SessionInfo info;
  std::unique_ptr<FrameSource> frames;
  std::unique_ptr<FrameSource> visibility;  ///< see SessionParts
};

/// What a status bar says.
struct SessionStatus {
  RelightStats stats;                          ///< of the last frame
  double frame_ms = 0;                         ///< wall time of the last frame
  std::string shadows_used;                    ///< see RelitFrame
  bool busy = false;                           ///< a frame or reference is being computed
  ShownPicture painted = ShownPicture::frame;  ///< what the picture really shows now
  bool outdated = false;                       ///< the picture is not yet what the view asks for
  PixelShare pixels = PixelShare::none;  ///< that the last frame shaded; the others are filled
  bool refined = false;                  ///< the painted frame is all samples with traced shadows
  std::optional<ImageError> error;       ///< frame against reference, when a heatmap is painted
  std::optional<double> map_mean;  ///< over covered pixels, when predicted or records is painted
  float heat_range = 0;            ///< value at the top of the scale; 0 = no scale
  std::string problem;             ///< one line, empty = none
};

/// What a session is made of. `scene` may be null when a cache was opened alone; `tracer` is over
/// *scene. A null `reference` means that there is none to compare with.
struct SessionParts {
  std::unique_ptr<const Scene> scene;
  std::unique_ptr<const Tracer> tracer;
  SessionInfo info;
  ViewState view;
  std::unique_ptr<FrameSource> frames;
  std::unique_ptr<FrameSource> reference;
  std::unique_ptr<FrameSource> visibility;  ///< see make_visibility_source(); null: none
};

/// One open view: the lights and settings that a person edits, and the pictures that follow from
/// them. Frames and references are computed on two worker threads; nothing here waits for them but
/// wait(). Used from one thread. No user interface in it.
class Session {
 public:
  explicit Session(SessionParts parts);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  const SessionInfo& info() const { return info_; }
  const CameraRays& rays() const { return rays_; }

  /// The scene's ray tracer; null when only a cache is open. Thread-safe.
  const Tracer* tracer() const { return tracer_.get(); }
  /// The records behind the frame, and behind the reference; null where the source has none.
  const RelightCache* cache() const { return cache_; }
  const RelightCache* reference_cache() const { return reference_cache_; }

  /// The scene-linear image that the picture shows; null while it shows a map, and before the
  /// first.
  const Image* shown_image() const;

  /// Adds the reference where there is none yet. `source` relights with traced shadows.
  void set_reference(std::unique_ptr<FrameSource> source);

  /// Goes on with other records of the same view. The picture stays until the first frame of them
  /// is there. What was there before ends in the background: nobody may use its cache any more.
  void set_records(SessionRecords records);

  /// Edited in place; update() notices what changed.
  ViewState& view() { return view_; }
  const ViewState& view() const { return view_; }

  /// Sends changed lights to the workers, takes what they finished and repaints the picture when it
  /// has to. `resting`: no light is being dragged; only then is the reference computed, and the
  /// curve config exact.
  void update(bool resting);

  /// update() until the picture is what the view asks for.
  void wait(bool resting);

  const Picture& picture() const { return picture_; }
  const SessionStatus& status() const { return status_; }

  /// The last frame that worked, scene-linear; an empty image before the first.
  const RelitFrame& frame() const { return frame_.latest; }

  /// `notify` is called, from a worker's thread, when update() has something to take. See
  /// RelightWorker::set_notify.
  void set_notify(const std::function<void()>& notify);

 private:
  /// A worker with what was asked of it and what came back.
  struct Channel {
    std::unique_ptr<RelightWorker> worker;  ///< null: no such source
    std::optional<RelightRequest> asked;
    RelitFrame incoming;
    RelitFrame latest;     ///< last frame without error
    uint64_t version = 0;  ///< frames taken so far without error; 0 = latest is empty
    std::string problem;   ///< of the last frame taken
  };

  /// All that the painted picture depends on.
  struct PaintKey {
    ShownPicture shown;
    uint64_t records;
    HeatRange heat_range;
    ToneCurve curve;
    float exposure;
    uint64_t frame;
    uint64_t reference;
    bool refined;
    bool false_color;
    uint64_t visibility;
    DisplayQuality quality;
    bool operator==(const PaintKey&) const = default;
  };

  bool ask(bool resting);
  bool ask_frame(bool resting);
  bool ask_reference(bool resting);
  bool ask_visibility();
  void connect(Channel& channel, std::unique_ptr<FrameSource> source);
  static void submit(Channel& channel, const RelightRequest& request);
  void take();
  static void take(Channel& channel);
  void paint(bool resting);
  bool frame_is_current() const;
  bool reference_is_current() const;
  bool visibility_is_current() const;
  const Light* selected_light() const;
  bool is_refined() const;
  ShownPicture paintable() const;
  void paint_image(const Image& image);
  void paint_heatmap();
  void paint_map(const std::vector<float>& values);
  void paint_scaled(const Image& values);
  void paint_difference();
  void paint_encoded(const Image& image);

  std::unique_ptr<const Scene> scene_;
  std::unique_ptr<const Tracer> tracer_;
  SessionInfo info_;
  CameraRays rays_;
  ViewState view_;
  Picture picture_;
  SessionStatus status_;
  std::string view_problem_;
  std::optional<PaintKey> painted_;
  std::function<void()> notify_;
  const RelightCache* cache_ = nullptr;
  const RelightCache* reference_cache_ = nullptr;
  FrameBudget budget_;
  uint64_t records_number_ = 0;  ///< tells records from those before
  std::future<void> retired_;    ///< former records, which may use tracer_
  Channel frame_;                // the channels go first: their sources may use tracer_
  Channel reference_;
  Channel visibility_;  ///< uses the frame's cache
};

/// A cache and its shadows for a session; without a tracer there are none.
SessionRecords make_session_records(RelightCache frames, const Tracer* tracer);

/// A session over a scene's caches. `frames` holds the reduced records; `reference`, prepared with
/// ReductionMethod::all, is relit with traced shadows and needs the tracer. The view starts with
/// the cache's lights and exposure and the first light selected.
Session make_session(std::unique_ptr<const Scene> scene, std::unique_ptr<const Tracer> tracer,
                     RelightCache frames, std::optional<RelightCache> reference);

}  // namespace relume
