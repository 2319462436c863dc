#include "viewer/display/script.h"

#include <fmt/format.h>

#include <charconv>
#include <sstream>

#include "core/base/error.h"
#include "core/base/file.h"

namespace relume {
namespace {

constexpr uint64_t max_script_bytes = 1 << 20;
constexpr float max_coordinate = 1e5f;

/// The words of one line, with the line's place for messages.
struct Line {
  std::string place;
  std::string rest;  ///< after the first word, blanks trimmed
  std::vector<std::string> words;

  [[noreturn]] void fail(const std::string& mend) const {
    throw input_error(place, "this step is not understood", mend);
  }
  void require_arguments(size_t count, const char* usage) const {
    if (words.size() != count + 1) fail(fmt::format("write: {}", usage));
  }
};

std::string trimmed(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

Line split_line(const std::string& text, const std::string& place) {
  Line line{.place = place, .rest = {}, .words = {}};
  std::istringstream stream(text);
  std::string word;
  while (stream >> word) line.words.push_back(word);
  const std::string whole = trimmed(text);
  const size_t end = whole.find_first_of(" \t");
  if (end != std::string::npos) line.rest = trimmed(whole.substr(end));
  return line;
}

float number(const Line& line, size_t index) {
  const std::string& word = line.words[index];
  float value = 0;
  const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
  const bool whole = result.ec == std::errc() && result.ptr == word.data() + word.size();
  if (!whole || !is_finite(value) || std::abs(value) > max_coordinate) {
    line.fail(fmt::format("'{}' should be a number", printable(word, 40)));
  }
  return value;
}

vec2 pair(const Line& line, size_t first) {
  const float x = number(line, first);
  const float y = number(line, first + 1);
  return {x, y};
}

/// "ITEM" or "X Y".
void read_target(const Line& line, const char* usage, ScriptStep& step) {
  if (line.words.size() == 2) {
    step.item = line.words[1];
  } else {
    line.require_arguments(2, usage);
    step.position = pair(line, 1);
  }
}

void read_screenshot(const Line& line, ScriptStep& step) {
  line.require_arguments(1, "screenshot FILE.png");
  const std::filesystem::path file = line.words[1];
  // The folder is the caller's to choose, not the script's.
  if (file.filename() != file || file.extension() != ".png") {
    line.fail("give a file name that ends in .png, without a folder");
  }
  step.text = line.words[1];
}

ScriptStep read_step(const Line& line) {
  const auto kind = value_of(step_kind_labels, line.words[0]);
  if (!kind) line.fail("start with one of: " + label_list(step_kind_labels));
  ScriptStep step{.kind = *kind, .item = {}, .position = vec2(0), .text = {}, .place = line.place};
  switch (*kind) {
    case StepKind::move:
      read_target(line, "move X Y, or move ITEM", step);
      break;
    case StepKind::click:
      read_target(line, "click X Y, or click ITEM", step);
      break;
    case StepKind::move_by:
      line.require_arguments(2, "move-by DX DY");
      step.position = pair(line, 1);
      break;
    case StepKind::drag:
      line.require_arguments(3, "drag ITEM DX DY");
      step.item = line.words[1];
      step.position = pair(line, 2);
      break;
    case StepKind::wheel:
      line.require_arguments(1, "wheel NOTCHES");
      step.position.x = number(line, 1);
      break;
    case StepKind::resize:
      line.require_arguments(2, "resize WIDTH HEIGHT");
      step.position = pair(line, 1);
      break;
    case StepKind::key:
      line.require_arguments(1, "key KEY");
      step.text = line.words[1];
      break;
    case StepKind::type:
      if (line.rest.empty()) line.fail("write: type TEXT");
      step.text = line.rest;
      break;
    case StepKind::drop:
      if (line.rest.empty()) line.fail("write: drop PATH");
      step.text = line.rest;
      break;
    case StepKind::screenshot:
      read_screenshot(line, step);
      break;
    case StepKind::press:
    case StepKind::release:
    case StepKind::wait:
    case StepKind::renew_context:
      line.require_arguments(0, "the word alone");
      break;
  }
  return step;
}

}  // namespace

Script parse_script(const std::string& text, const std::string& place) {
  Script script;
  std::istringstream lines(text);
  std::string line_text;
  for (int number = 1; std::getline(lines, line_text); ++number) {
    const Line line = split_line(line_text, fmt::format("{}:{}", place, number));
    if (line.words.empty() || line.words[0].starts_with('#')) continue;
    script.steps.push_back(read_step(line));
  }
  return script;
}

Script load_script(const std::filesystem::path& path) {
  return parse_script(read_text_file(path, max_script_bytes), path.string());
}

}  // namespace relume
