#pragma once

#include <array>
#include <string_view>

namespace relume {

/// A study that `relume study` knows.
struct StudyName {
  std::string_view name;
  std::string_view help;
};

/// In the order in which `all` runs them.
inline constexpr std::array study_names = {
    StudyName{"methods", "TR2007-600 experiment 1: every method at 8 records, random lights"},
    StudyName{"rates", "experiment 2: 8, 4 and 2 records"},
    StudyName{"lights", "experiment 3: 12 to 800 training lights"},
    StudyName{"smooth", "figure 3: spheres at 2 records, errors ten times enlarged"},
    StudyName{"pictures", "figures 1 and 8 to 13: pictures and maps of their error"},
    StudyName{"shadows", "shadow methods against a traced truth"},
    StudyName{"tradeoff", "error against milliseconds a light move; what to choose"},
    StudyName{"stability", "scale, distance, exponent, intensity, thinness against double numbers"},
    StudyName{"all", "all of the above"},
};

/// Null for a name that is none.
constexpr const StudyName* find_study(std::string_view name) {
  for (const StudyName& study : study_names) {
    if (study.name == name) return &study;
  }
  return nullptr;
}

}  // namespace relume
