#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace relume {

/// One row of figures: names and values in order.
using Figure = std::variant<double, int64_t, std::string, bool>;
using FigureRow = std::vector<std::pair<std::string, Figure>>;

/// A table of figures with a name.
struct FigureTable {
  std::string name;
  std::vector<FigureRow> rows;
};

}  // namespace relume
