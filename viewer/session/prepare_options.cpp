#include "viewer/session/prepare_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>

namespace relume {

std::vector<std::string> prepare_flags(const PrepareOptions& options, uint64_t seed) {
  const PrepareOptions defaults;
  std::vector<std::string> flags;
  const auto add = [&](bool differs, const char* flag, const auto& value) {
    if (!differs) return;
    flags.emplace_back(flag);
    flags.push_back(fmt::format("{}", value));
  };
  add(options.spp != defaults.spp, "--spp", options.spp);
  add(options.method != defaults.method, "--method",
      label_of(reduction_method_labels, options.method));
  add(options.records.has_value(), "--records", options.records.value_or(0));
  add(options.budget.average_records > 0, "--average-records", options.budget.average_records);
  add(options.budget.target_error > 0, "--target-error", options.budget.target_error);
  add(options.members.has_value(), "--members", options.members.value_or(0));
  if (options.predict_error) flags.emplace_back("--predict-error");
  if (options.format) add(true, "--format", label_of(cache_format_labels, *options.format));
  add(options.training_lights != defaults.training_lights, "--training-lights",
      options.training_lights);
  if (options.train_shadows) flags.emplace_back("--train-shadows");
  add(options.preset != defaults.preset, "--preset",
      label_of(reduction_preset_labels, options.preset));
  add(options.width > 0, "--width", options.width);
  add(options.height > 0, "--height", options.height);
  add(seed != 0, "--seed", seed);
  return flags;
}

PrepareOptions chosen_options(PrepareOptions options, const CacheInfo& info) {
  if (!(options.frame_ms > 0)) return options;
  options.frame_ms = 0;
  options.format = info.format;
  options.records = info.records;
  options.budget = {info.average_records, info.target_error};
  return options;
}

PrepareOptions with_records(PrepareOptions options, const RecordChoice& records) {
  if (!records.is_set()) return options;
  options.frame_ms = 0;
  options.records.reset();
  options.budget = {.average_records = records.average};
  options.format = records.format;
  return options;
}

std::optional<PrepareOptions> options_of(const CacheInfo& info) {
  const auto method = value_of(reduction_method_labels, info.method);
  if (!method || *method == ReductionMethod::all || *method == ReductionMethod::pure) return {};
  PrepareOptions options;
  options.spp = info.spp;
  options.method = *method;
  options.width = info.width;
  options.height = info.height;
  return options;
}

std::string shell_quoted(const std::string& argument) {
  const bool is_plain =
      !argument.empty() && std::all_of(argument.begin(), argument.end(), [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
               std::strchr("_-./+=:", c) != nullptr;
      });
  if (is_plain) return argument;
  std::string quoted = "'";
  for (const char c : argument) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace relume
