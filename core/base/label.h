#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace relume {

/// One row of an enum's label table. Each enum has exactly one table (style habit 3); command line,
/// files, panels and studies all use it.
template <class E>
struct Label {
  E value;
  std::string_view name;
};

/// The label of `value`, or "?" when the table lacks it.
template <class E, size_t N>
constexpr std::string_view label_of(const std::array<Label<E>, N>& table, E value) {
  for (const Label<E>& row : table) {
    if (row.value == value) return row.name;
  }
  return "?";
}

/// The value that carries `name`, if any.
template <class E, size_t N>
constexpr std::optional<E> value_of(const std::array<Label<E>, N>& table, std::string_view name) {
  for (const Label<E>& row : table) {
    if (row.name == name) return row.value;
  }
  return std::nullopt;
}

/// All labels, separated by ", ", for messages.
template <class E, size_t N>
std::string label_list(const std::array<Label<E>, N>& table) {
  std::string text;
  for (const Label<E>& row : table) {
    if (!text.empty()) text += ", ";
    text += row.name;
  }
  return text;
}

}  // namespace relume
