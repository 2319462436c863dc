#include "viewer/session/edit_history.h"

namespace relume {

void EditHistory::reset(const ViewState& view) {
  steps_.clear();
  done_ = 0;
  lights_ = view.lights;
  settings_ = settings_of(view);
}

bool EditHistory::commit(const ViewState& view) {
  const std::vector<Light>& now = view.lights;
  const size_t shared = std::min(now.size(), lights_.size());
  size_t first = 0;
  while (first < shared && same_light(now[first], lights_[first])) ++first;
  size_t last = 0;  // lights at the end that did not change
  while (last < shared - first &&
         same_light(now[now.size() - 1 - last], lights_[lights_.size() - 1 - last])) {
    ++last;
  }
  Settings settings = settings_of(view);
  const bool same_lights = now.size() == lights_.size() && first + last == now.size();
  if (same_lights && same_edits(settings, settings_)) {
    settings_.selected_light = settings.selected_light;
    settings_.records = settings.records;
    return false;
  }
  const auto part = [&](const std::vector<Light>& lights) {
    return std::vector<Light>(lights.begin() + static_cast<ptrdiff_t>(first),
                              lights.end() - static_cast<ptrdiff_t>(last));
  };
  steps_.resize(done_);
  steps_.push_back({first, part(lights_), part(now), settings_, settings});
  ++done_;
  replace_lights(first, steps_.back().removed.size(), steps_.back().added);
  settings_ = std::move(settings);
  return true;
}

bool EditHistory::undo(ViewState& view) {
  commit(view);
  if (!can_undo()) return false;
  const Step& step = steps_[--done_];
  replace_lights(step.first, step.added.size(), step.removed);
  settings_ = step.before;
  view.lights = lights_;
  apply(settings_, view);
  return true;
}

bool EditHistory::redo(ViewState& view) {
  commit(view);
  if (!can_redo()) return false;
  const Step& step = steps_[done_++];
  replace_lights(step.first, step.removed.size(), step.added);
  settings_ = step.after;
  view.lights = lights_;
  apply(settings_, view);
  return true;
}

EditHistory::Settings EditHistory::settings_of(const ViewState& view) {
  return {view.shadows, view.display,     view.heat_range,     view.frame_ms, view.refine,
          view.trade,   view.solo_lights, view.selected_light, view.records};
}

bool EditHistory::same_edits(const Settings& a, const Settings& b) {
  return a.shadows == b.shadows && a.display.exposure == b.display.exposure &&
         a.display.curve == b.display.curve && a.heat_range == b.heat_range &&
         a.frame_ms == b.frame_ms && a.refine == b.refine && a.trade == b.trade &&
         a.solo_lights == b.solo_lights;
}

void EditHistory::apply(const Settings& settings, ViewState& view) {
  view.shadows = settings.shadows;
  view.display = settings.display;
  view.heat_range = settings.heat_range;
  view.frame_ms = settings.frame_ms;
  view.refine = settings.refine;
  view.trade = settings.trade;
  view.solo_lights = settings.solo_lights;
  view.selected_light = settings.selected_light;
  view.records = settings.records;
}

void EditHistory::replace_lights(size_t first, size_t count, const std::vector<Light>& lights) {
  const auto place = lights_.begin() + static_cast<ptrdiff_t>(first);
  const auto next = lights_.erase(place, place + static_cast<ptrdiff_t>(count));
  lights_.insert(next, lights.begin(), lights.end());
}

}  // namespace relume
