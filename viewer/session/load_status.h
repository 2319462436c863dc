#pragma once

#include <string>

namespace relume {

/// How far work in the background is.
struct LoadStatus {
  std::string input;
  std::string stage;         ///< what is being done, for instance "prepare hair"
  double fraction = 0;       ///< of the stage, in [0, 1]
  double seconds_left = -1;  ///< < 0: unknown
  bool opening = false;      ///< the session is not there yet
  bool working = false;      ///< something is being prepared
  std::string problem;       ///< why it failed, one line; empty = it did not
};

}  // namespace relume
