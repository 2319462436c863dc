#include "viewer/commands/json_output.h"

#include <fmt/format.h>

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

}  // namespace

std::string format_figures(const std::string& schema, const CommonOptions& common,
                           const std::vector<FigureRow>& rows) {
  nlohmann::ordered_json json;
  json["schema"] = schema;
  json["version"] = relume_version;
  json["commit"] = relume_commit;
  json["cpu"] = cpu_name();
  json["threads"] = thread_count();
  json["seed"] = common.seed;
  json["rows"] = nlohmann::ordered_json::array();
  for (const FigureRow& row : rows) {
    nlohmann::ordered_json object;
    for (const auto& [name, figure] : row) object[name] = to_json(figure);
    json["rows"].push_back(object);
  }
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

void print_figures(const std::string& schema, const CommonOptions& common,
                   const std::vector<FigureRow>& rows) {
  if (common.json) {
    fmt::print("{}", format_figures(schema, common, rows));
    return;
  }
  for (const FigureRow& row : rows) {
    for (const auto& [name, figure] : row) fmt::print("{:<18} {}\n", name, to_text(figure));
    if (&row != &rows.back()) fmt::print("\n");
  }
}

}  // namespace relume
