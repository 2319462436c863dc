#include "core/scene/io/pbrt_text.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>

#include "core/scene/io/packed_file.h"

namespace relume {
namespace {

constexpr size_t max_include_depth = 32;
constexpr int max_includes = 10'000;

/// What follows a statement's name: quoted words, numbers, then perhaps parameters.
struct Form {
  std::string_view name;
  int words = 0;  ///< -1: any number
  int numbers = 0;
  bool has_parameters = false;
};

constexpr std::array forms = {
    Form{"Accelerator", 1, 0, true},
    Form{"AreaLightSource", 1, 0, true},
    Form{"Attribute", 1, 0, true},
    Form{"AttributeBegin"},
    Form{"AttributeEnd"},
    Form{"Camera", 1, 0, true},
    Form{"ColorSpace", 1},
    Form{"ConcatTransform", 0, 16},
    Form{"CoordSysTransform", 1},
    Form{"CoordinateSystem", 1},
    Form{"Film", 1, 0, true},
    Form{"Identity"},
    Form{"Import", 1},
    Form{"Include", 1},
    Form{"Integrator", 1, 0, true},
    Form{"LightSource", 1, 0, true},
    Form{"LookAt", 0, 9},
    Form{"MakeNamedMaterial", 1, 0, true},
    Form{"MakeNamedMedium", 1, 0, true},
    Form{"Material", 1, 0, true},
    Form{"MediumInterface", -1},
    Form{"NamedMaterial", 1},
    Form{"ObjectBegin", 1},
    Form{"ObjectEnd"},
    Form{"ObjectInstance", 1},
    Form{"Option", 0, 0, true},
    Form{"PixelFilter", 1, 0, true},
    Form{"ReverseOrientation"},
    Form{"Rotate", 0, 4},
    Form{"Sampler", 1, 0, true},
    Form{"Scale", 0, 3},
    Form{"Shape", 1, 0, true},
    Form{"SurfaceIntegrator", 1, 0, true},
    Form{"Texture", 3, 0, true},
    Form{"Transform", 0, 16},
    Form{"TransformBegin"},
    Form{"TransformEnd"},
    Form{"TransformTimes", 0, 2},
    Form{"Translate", 0, 3},
    Form{"WorldBegin"},
    Form{"WorldEnd"},
};

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

bool ends_word(char c) {
  return is_blank(c) || c == '"' || c == '[' || c == ']' || c == '#';
}

}  // namespace

enum class PbrtTokenKind { end, word, quoted, open, close };

struct PbrtReader::Token {
  PbrtTokenKind kind = PbrtTokenKind::end;
  std::string_view text;
};

struct PbrtReader::Source {
  std::string name;
  PackedFile file;
  std::string_view rest;
  int line = 1;
};

const PbrtParameter* PbrtParameters::find(std::string_view name) const {
  for (const PbrtParameter& parameter : list) {
    if (parameter.name == name) return &parameter;
  }
  return nullptr;
}

std::span<const double> PbrtParameters::numbers(std::string_view name, size_t width) const {
  const PbrtParameter* found = find(name);
  if (found == nullptr) return {};
  if (!found->texts.empty() || found->numbers.size() % width != 0) {
    fail(fmt::format("parameter \"{}\" has {} numbers and {} texts", name, found->numbers.size(),
                     found->texts.size()),
         width == 1 ? std::string("give numbers") : fmt::format("give {} numbers each", width));
  }
  return found->numbers;
}

double PbrtParameters::number(std::string_view name, double fallback) const {
  if (!has(name)) return fallback;
  const auto values = numbers(name, 1);
  if (values.size() != 1) fail(fmt::format("parameter \"{}\" is no number", name), "give one");
  return values[0];
}

int64_t PbrtParameters::integer(std::string_view name, int64_t fallback) const {
  const double value = number(name, static_cast<double>(fallback));
  if (!(std::abs(value) <= 1e9) || value != std::floor(value)) {
    fail(fmt::format("parameter \"{}\" is {}", name, value), "give a whole number");
  }
  return static_cast<int64_t>(value);
}

vec3 PbrtParameters::vector(std::string_view name, vec3 fallback) const {
  if (!has(name)) return fallback;
  const auto values = numbers(name, 3);
  if (values.size() != 3)
    fail(fmt::format("parameter \"{}\" is no vector", name), "give 3 numbers");
  return {values[0], values[1], values[2]};
}

std::string PbrtParameters::text(std::string_view name, const std::string& fallback) const {
  const PbrtParameter* found = find(name);
  if (found == nullptr) return fallback;
  if (found->texts.size() != 1) fail(fmt::format("parameter \"{}\" is no text", name), "give one");
  return found->texts[0];
}

bool PbrtParameters::flag(std::string_view name, bool fallback) const {
  const std::string value = text(name, fallback ? "true" : "false");
  if (value != "true" && value != "false") {
    fail(fmt::format("parameter \"{}\" is \"{}\"", name, value), "give true or false");
  }
  return value == "true";
}

std::filesystem::path pbrt_file(const std::filesystem::path& folder, const std::string& name,
                                const std::string& place) {
  const std::filesystem::path beside_scene = folder / name;
  std::error_code ignored;
  if (std::filesystem::exists(beside_scene, ignored)) return beside_scene;
  const size_t end = place.rfind(':');
  const std::filesystem::path from = place.substr(0, end);
  const std::filesystem::path beside_file = from.parent_path() / name;
  return std::filesystem::exists(beside_file, ignored) ? beside_file : beside_scene;
}

PbrtReader::PbrtReader(const std::filesystem::path& path) : folder_(path.parent_path()) {
  auto source = std::make_unique<Source>();
  source->name = path.string();
  source->file = PackedFile(path);
  source->rest = source->file.text();
  sources_.push_back(std::move(source));
}

PbrtReader::~PbrtReader() = default;

std::string PbrtReader::place() const {
  return fmt::format("{}:{}", sources_.back()->name, sources_.back()->line);
}

PbrtReader::Token PbrtReader::take() {
  Source& source = *sources_.back();
  std::string_view& rest = source.rest;
  while (!rest.empty() && (is_blank(rest.front()) || rest.front() == '#')) {
    if (rest.front() == '#') {
      rest.remove_prefix(std::min(rest.find('\n'), rest.size()));
      continue;
    }
    source.line += rest.front() == '\n' ? 1 : 0;
    rest.remove_prefix(1);
  }
  if (rest.empty()) return {};
  if (rest.front() == '[' || rest.front() == ']') {
    const Token bracket{rest.front() == '[' ? PbrtTokenKind::open : PbrtTokenKind::close,
                        rest.substr(0, 1)};
    rest.remove_prefix(1);
    return bracket;
  }
  if (rest.front() == '"') {
    const size_t end = rest.find_first_of("\"\n", 1);
    if (end == std::string_view::npos || rest[end] == '\n') {
      throw input_error(place(), "a quoted text does not end", "add the missing quote");
    }
    const Token quoted{PbrtTokenKind::quoted, rest.substr(1, end - 1)};
    rest.remove_prefix(end + 1);
    return quoted;
  }
  size_t end = 1;
  while (end < rest.size() && !ends_word(rest[end])) ++end;
  const Token word{PbrtTokenKind::word, rest.substr(0, end)};
  rest.remove_prefix(end);
  return word;
}

PbrtReader::Token PbrtReader::look() {
  Source& source = *sources_.back();
  const std::string_view rest = source.rest;
  const int line = source.line;
  const Token token = take();
  source.rest = rest;
  source.line = line;
  return token;
}

double PbrtReader::number_of(const Token& token) const {
  std::string_view text = token.text;
  if (token.kind == PbrtTokenKind::word && text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_whole = error == std::errc() && end == text.data() + text.size();
  if (token.kind != PbrtTokenKind::word || !is_whole || !std::isfinite(value)) {
    throw input_error(place(), fmt::format("\"{}\" is no number", token.text), "give a number");
  }
  return value;
}

std::optional<PbrtStatement> PbrtReader::next() {
  while (true) {
    const Token token = take();
    if (token.kind == PbrtTokenKind::end) {
      if (sources_.size() == 1) return std::nullopt;
      sources_.pop_back();
      continue;
    }
    if (token.kind != PbrtTokenKind::word) {
      throw input_error(place(), fmt::format("\"{}\" stands where a statement begins", token.text),
                        "check what is before it");
    }
    PbrtStatement statement = read_statement(token);
    if (statement.name != "Include" && statement.name != "Import") return statement;
    include(statement.words[0], statement.parameters.place);
  }
}

void PbrtReader::include(const std::string& name, const std::string& place) {
  if (sources_.size() >= max_include_depth || ++included_ > max_includes) {
    throw limit_error(place, "includes too much",
                      fmt::format("the limits are {} files in each other and {} together",
                                  max_include_depth, max_includes));
  }
  const std::filesystem::path path = pbrt_file(folder_, name, place);
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {
    throw input_error(place, fmt::format("includes \"{}\", which is missing", name),
                      "check the path");
  }
  auto source = std::make_unique<Source>();
  source->name = path.string();
  source->file = PackedFile(path);
  source->rest = source->file.text();
  sources_.push_back(std::move(source));
}

PbrtStatement PbrtReader::read_statement(const Token& name) {
  const auto form = std::ranges::find(forms, name.text, &Form::name);
  PbrtStatement statement;
  statement.name = name.text;
  statement.parameters.place = place();
  if (name.text == "ActiveTransform") {
    statement.words.emplace_back(take().text);
    return statement;
  }
  if (form == forms.end()) {
    throw input_error(place(), fmt::format("unknown statement {}", name.text),
                      "give a pbrt-v3 or pbrt-v4 scene");
  }
  read_words(form->words, statement);
  read_numbers(form->numbers, statement);
  if (form->has_parameters) read_parameters(statement);
  return statement;
}

void PbrtReader::read_words(int count, PbrtStatement& statement) {
  for (int i = 0; count < 0 || i < count; ++i) {
    if (count < 0 && look().kind != PbrtTokenKind::quoted) return;
    const Token token = take();
    if (token.kind != PbrtTokenKind::quoted) {
      throw input_error(place(), fmt::format("{} lacks a quoted name", statement.name),
                        "give it in quotes");
    }
    statement.words.emplace_back(token.text);
  }
}

void PbrtReader::read_numbers(int count, PbrtStatement& statement) {
  const bool is_bracketed = count > 0 && look().kind == PbrtTokenKind::open;
  if (is_bracketed) take();
  for (int i = 0; i < count; ++i) statement.numbers.push_back(number_of(take()));
  if (is_bracketed && take().kind != PbrtTokenKind::close) {
    throw input_error(place(), fmt::format("{} has more than {} numbers", statement.name, count),
                      "remove the rest");
  }
}

void PbrtReader::read_parameters(PbrtStatement& statement) {
  while (look().kind == PbrtTokenKind::quoted) {
    statement.parameters.list.push_back(read_parameter(take()));
  }
}

PbrtParameter PbrtReader::read_parameter(const Token& head) {
  const size_t start = std::min(head.text.find_first_not_of(" \t"), head.text.size());
  const size_t space = head.text.find_first_of(" \t", start);
  if (space == std::string_view::npos) {
    throw input_error(place(), fmt::format("parameter \"{}\" has no type", head.text),
                      "give \"TYPE NAME\"");
  }
  PbrtParameter parameter;
  parameter.type = head.text.substr(start, space - start);
  const size_t name = std::min(head.text.find_first_not_of(" \t", space), head.text.size());
  parameter.name = head.text.substr(name, head.text.find_first_of(" \t", name) - name);
  Token token = take();
  if (token.kind != PbrtTokenKind::open) {
    add_value(token, parameter);
    return parameter;
  }
  for (token = take(); token.kind != PbrtTokenKind::close; token = take()) {
    add_value(token, parameter);
  }
  return parameter;
}

void PbrtReader::add_value(const Token& token, PbrtParameter& parameter) const {
  const bool is_flag = token.text == "true" || token.text == "false";
  if (token.kind == PbrtTokenKind::quoted || (token.kind == PbrtTokenKind::word && is_flag)) {
    parameter.texts.emplace_back(token.text);
  } else if (token.kind == PbrtTokenKind::word) {
    parameter.numbers.push_back(number_of(token));
  } else {
    throw input_error(place(), fmt::format("parameter \"{}\" does not end", parameter.name),
                      "close it with ]");
  }
}

}  // namespace relume
