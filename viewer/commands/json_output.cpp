#include "viewer/commands/json_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/parallel.h"
#include "viewer/commands/version.h"

namespace relume {
namespace {

std::string cpu_name() {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line)) {
    const size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

nlohmann::ordered_json to_json(const Figure& figure) {
  if (const double* number = std::get_if<double>(&figure)) {
    return std::isfinite(*number) ? nlohmann::ordered_json(*number) : nlohmann::ordered_json();
  }
  return std::visit([](const auto& value) { return nlohmann::ordered_json(value); }, figure);
}

std::string to_text(const Figure& figure) {
  if (const double* number = std::get_if<double>(&figure)) return fmt::format("{:.6g}", *number);
  return std::visit([](const auto& value) { return fmt::format("{}", value); }, figure);
}

/// As RFC 4180 wants it.
std::string to_csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char letter : text) quoted += letter == '"' ? "\"\"" : std::string(1, letter);
  return quoted + "\"";
}

bool same_names(const FigureRow& a, const FigureRow& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& x, const auto& y) { return x.first == y.first; });
}

/// One row as lines "name value".
void append_lines(const FigureRow& row, std::string& text) {
  for (const auto& [name, figure] : row) text += fmt::format("{:<18} {}\n", name, to_text(figure));
}

/// Rows of the same names: a line of names and one of values each; the first column to the left.
void append_columns(std::span<const FigureRow> rows, std::string& text) {
  std::vector<std::string> lines(rows.size() + 1);
  for (size_t column = 0; column < rows[0].size(); ++column) {
    std::vector<std::string> cells{rows[0][column].first};
    for (const FigureRow& row : rows) cells.push_back(to_text(row[column].second));
    size_t width = 0;
    for (const std::string& cell : cells) width = std::max(width, cell.size());
    for (size_t i = 0; i < cells.size(); ++i) {
      lines[i] += column == 0 ? fmt::format("{:<{}}", cells[i], width)
                              : fmt::format("  {:>{}}", cells[i], width);
    }
  }
  for (const std::string& line : lines) text += line + "\n";
}

}  // namespace

std::string format_table(std::span<const FigureRow> rows) {
  std::string text;
  for (size_t first = 0; first < rows.size();) {
    size_t end = first + 1;
    while (end < rows.size() && same_names(rows[first], rows[end])) ++end;
    if (first > 0) text += "\n";
    if (end - first == 1) {
      append_lines(rows[first], text);
    } else {
      append_columns(rows.subspan(first, end - first), text);
    }
    first = end;
  }
  return text;
}

std::string format_figures(const std::string& schema, const CommonOptions& common,
                           const std::vector<FigureRow>& rows) {
  const FigureTable table{"rows", rows};
  return format_tables(schema, common, {&table, 1});
}

std::string format_tables(const std::string& schema, const CommonOptions& common,
                          std::span<const FigureTable> tables) {
  nlohmann::ordered_json json;
  json["schema"] = schema;
  json["version"] = relume_version;
  json["commit"] = relume_commit;
  json["cpu"] = cpu_name();
  json["threads"] = thread_count();
  json["seed"] = common.seed;
  for (const FigureTable& table : tables) {
    json[table.name] = nlohmann::ordered_json::array();
    for (const FigureRow& row : table.rows) {
      nlohmann::ordered_json object;
      for (const auto& [name, figure] : row) object[name] = to_json(figure);
      json[table.name].push_back(object);
    }
  }
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string format_csv(const std::vector<FigureRow>& rows) {
  std::string text;
  const auto add_line = [&text](const FigureRow& row, const auto& cell) {
    for (size_t i = 0; i < row.size(); ++i) {
      if (i > 0) text += ',';
      text += cell(row[i]);
    }
    text += '\n';
  };
  if (!rows.empty()) add_line(rows.front(), [](const auto& entry) { return entry.first; });
  for (const FigureRow& row : rows) {
    add_line(row, [](const auto& entry) {
      return std::visit([](const auto& value) { return to_csv_cell(fmt::format("{}", value)); },
                        entry.second);
    });
  }
  return text;
}

void print_figures(const std::string& schema, const CommonOptions& common,
                   const std::vector<FigureRow>& rows) {
  if (common.json) {
    fmt::print("{}", format_figures(schema, common, rows));
    return;
  }
  fmt::print("{}", format_table(rows));
}

}  // namespace relume
