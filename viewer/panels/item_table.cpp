#include "viewer/panels/item_table.h"

namespace relume {

std::optional<Rect> ItemTable::find(std::string_view name) const {
  const auto found = items_.find(name);
  if (found == items_.end()) return std::nullopt;
  return found->second;
}

std::string ItemTable::names() const {
  std::string text;
  for (const auto& [name, rect] : items_) {
    if (!text.empty()) text += ", ";
    text += name;
  }
  return text;
}

}  // namespace relume
