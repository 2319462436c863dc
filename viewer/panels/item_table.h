#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "viewer/panels/placement.h"

namespace relume {

/// Where the parts of the user interface stood in the last frame, by name ("light.gain"), so that
/// scripts and tests click what they mean instead of a pixel.
class ItemTable {
 public:
  void clear() { items_.clear(); }
  void note(std::string_view name, const Rect& rect) {
    items_.insert_or_assign(std::string(name), rect);
  }
  std::optional<Rect> find(std::string_view name) const;
  /// All names, sorted, separated by ", ".
  std::string names() const;

 private:
  std::map<std::string, Rect, std::less<>> items_;
};

}  // namespace relume
