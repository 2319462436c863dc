#pragma once

#include <map>
#include <string>

#include "shadow/shadow_method.h"

namespace relume {

/// How good shadows must be now: while a light is dragged, when it rests, and at the end, when time
/// does not count.
enum class ShadowLevel { drag, rest, final };

inline constexpr std::array shadow_level_labels = {
    Label<ShadowLevel>{ShadowLevel::drag, "drag"},
    Label<ShadowLevel>{ShadowLevel::rest, "rest"},
    Label<ShadowLevel>{ShadowLevel::final, "final"},
};

/// What the choice of a method depends on beside time.
struct ShadowContent {
  bool has_thin_geometry = false;  ///< see SceneStrips
  bool has_members = false;        ///< records of several samples keep them
};

struct ShadowChoice {
  ShadowMethod method = ShadowMethod::ray;
  std::string reason;  ///< for a status bar, such as "coverage: 31 of 40 ms"
};

/// Picks a method by what there is to shadow and by measured times. Solids alone are traced at
/// every level, and at the final one everything is, from all members. Else the first of `coverage`,
/// `opacity` and `volume` that fits the budget; `volume` when none does. A method that was never
/// timed is judged by one that was (typical_cost) and tried only when it should fit; until anything
/// was timed the last one is taken. So that choices do not flicker, a method that is not in use
/// must fit four fifths of the budget.
class ShadowChooser {
 public:
  explicit ShadowChooser(const ShadowContent& content) : content_(content) {}

  /// `budget_ms` > 0: of a light move, prepare() and all look-ups.
  ShadowChoice choose(ShadowLevel level, double budget_ms);

  /// What a move took with `method`; later ones count for a half.
  void add_time(ShadowMethod method, double ms);

 private:
  double expected_ms(ShadowMethod method) const;

  ShadowContent content_;
  std::map<ShadowMethod, double> times_ms_;
  std::map<ShadowLevel, ShadowMethod> last_;
};

}  // namespace relume
