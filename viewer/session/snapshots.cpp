#include "viewer/session/snapshots.h"

namespace relume {
namespace {

constexpr size_t max_snapshots = 64;

bool same_display(const ViewState& a, const ViewState& b) {
  return a.display.exposure == b.display.exposure && a.display.curve == b.display.curve &&
         a.false_color == b.false_color;
}

}  // namespace

void Snapshots::take(const Session& session) {
  if (session.picture().version == 0 || snapshots_.size() >= max_snapshots) return;
  Snapshot snapshot{session.view(), {}, session.picture()};
  if (const Image* image = session.shown_image()) snapshot.image = *image;
  snapshot.picture.version = ++last_version_;
  snapshot.is_draft = session.view().display.curve == ToneCurve::config;
  snapshots_.push_back(std::move(snapshot));
  selected_ = static_cast<int>(snapshots_.size()) - 1;
}

void Snapshots::clear() {
  snapshots_.clear();
  selected_ = -1;
}

void Snapshots::select(int index) {
  if (index < 0 || index >= static_cast<int>(snapshots_.size())) return;
  selected_ = index;
  snapshots_[static_cast<size_t>(index)].picture.version = ++last_version_;
}

const Snapshot* Snapshots::current() const {
  return selected_ >= 0 ? &snapshots_[static_cast<size_t>(selected_)] : nullptr;
}

void Snapshots::follow(const ViewState& view, bool resting) {
  if (selected_ < 0) return;
  Snapshot& snapshot = snapshots_[static_cast<size_t>(selected_)];
  const bool is_final = !snapshot.is_draft || !resting;
  if (snapshot.image.pixels.empty() || (same_display(snapshot.view, view) && is_final)) return;
  snapshot.view.display = view.display;
  snapshot.view.false_color = view.false_color;
  snapshot.is_draft = !resting && view.display.curve == ToneCurve::config;
  display_image(snapshot.image, view, resting ? DisplayQuality::exact : DisplayQuality::draft,
                snapshot.picture.rgba);
  snapshot.picture.version = ++last_version_;
}

}  // namespace relume
