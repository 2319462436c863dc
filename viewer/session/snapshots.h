#pragma once

#include <vector>

#include "viewer/session/session.h"

namespace relume {

/// A picture kept to compare with, and what it showed.
struct Snapshot {
  ViewState view;
  Image image;            ///< scene-linear, follows exposure and curve; empty where a map was shown
  Picture picture;        ///< for the screen; its version counts through all snapshots
  bool is_draft = false;  ///< its colours may have to become exact
};

/// Pictures kept beside the live one, of one session.
class Snapshots {
 public:
  /// Keeps what the session shows, at the end, and selects it. Nothing before the first picture,
  /// and nothing beyond 64.
  void take(const Session& session);
  void clear();

  const std::vector<Snapshot>& all() const { return snapshots_; }
  /// Index of the one that is compared with, or -1.
  int selected() const { return selected_; }
  void select(int index);
  const Snapshot* current() const;

  /// Paints the selected one as `view` displays pictures now; see Session::update() for `resting`.
  void follow(const ViewState& view, bool resting);

 private:
  std::vector<Snapshot> snapshots_;
  int selected_ = -1;
  uint64_t last_version_ = 0;
};

}  // namespace relume
