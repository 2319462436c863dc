#pragma once

#include <deque>
#include <vector>

#include "viewer/session/view_state.h"

namespace relume {

/// Undo and redo without limit over what a person edits: the lights and the settings that change
/// the picture. Choosing what is shown, selecting and zooming are no edits. A step keeps only what
/// it changed.
class EditHistory {
 public:
  /// Forgets everything; `view` is where the next step starts.
  void reset(const ViewState& view);

  /// Makes one step of all that changed since the last; to be called when nothing is being dragged.
  /// What could be redone is then gone. False when nothing changed.
  bool commit(const ViewState& view);

  /// Takes back the last step, or does it again; edits not committed become a step first. False
  /// when there is none.
  bool undo(ViewState& view);
  bool redo(ViewState& view);

  bool can_undo() const { return done_ > 0; }
  bool can_redo() const { return done_ < steps_.size(); }
  /// Steps done since the start; a number that tells states apart.
  size_t step_count() const { return done_; }

 private:
  /// What undo brings back beside the lights.
  struct Settings {
    ShadowMethod shadows = ShadowMethod::ray;
    DisplayTransform display;
    HeatRange heat_range = HeatRange::ten_times;
    float frame_ms = 0;
    bool refine = false;
    Trade trade;
    std::vector<int> solo_lights;
    int selected_light = -1;  ///< brought back, but no edit by itself
    RecordChoice records;     ///< the same: the trade chooses them, and later
  };
  /// Lights [first, first + removed.size()) gave way to `added`.
  struct Step {
    size_t first = 0;
    std::vector<Light> removed;
    std::vector<Light> added;
    Settings before;
    Settings after;
  };

  static Settings settings_of(const ViewState& view);
  static bool same_edits(const Settings& a, const Settings& b);
  static void apply(const Settings& settings, ViewState& view);
  void replace_lights(size_t first, size_t count, const std::vector<Light>& lights);

  std::vector<Light> lights_;  ///< after the steps done
  Settings settings_;
  std::deque<Step> steps_;
  size_t done_ = 0;  ///< steps_[0, done_) are in effect
};

}  // namespace relume
