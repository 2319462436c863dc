#include "core/scene/io/json_node.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

namespace relume {
namespace {

constexpr size_t max_text_bytes = size_t{64} << 20;
constexpr int max_depth = 64;

/// Edit distance (Levenshtein) of two short strings.
size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

std::string suggest(std::string_view key, const std::string_view* keys, size_t count) {
  std::string_view best;
  size_t best_distance = std::max<size_t>(2, key.size() / 2);
  std::string all;
  for (size_t i = 0; i < count; ++i) {
    const size_t distance = edit_distance(key.substr(0, 64), keys[i]);
    if (distance <= best_distance && (best.empty() || distance < best_distance)) {
      best = keys[i];
      best_distance = distance;
    }
    all += fmt::format("{}{}", i == 0 ? "" : ", ", keys[i]);
  }
  return best.empty() ? "known keys: " + all : fmt::format("did you mean \"{}\"?", best);
}

/// Watches depth and duplicate keys while the parser runs.
class ParseWatch {
 public:
  explicit ParseWatch(const std::string& file) : file_(file) {}

  bool operator()(int depth, nlohmann::json::parse_event_t event, const nlohmann::json& parsed) {
    using Event = nlohmann::json::parse_event_t;
    if (depth > max_depth) {
      throw limit_error(file_, fmt::format("is nested deeper than {} levels", max_depth),
                        "flatten it");
    }
    if (event == Event::object_start) keys_.emplace_back();
    if (event == Event::object_end && !keys_.empty()) keys_.pop_back();
    if (event == Event::key && !keys_.empty()) {
      const std::string key = parsed.get<std::string>();
      if (!keys_.back().insert(key).second) {
        throw input_error(file_, fmt::format("key \"{}\" is given twice in one object", key),
                          "remove one of them");
      }
    }
    return true;
  }

 private:
  const std::string& file_;
  std::vector<std::set<std::string>> keys_;
};

/// The position of a byte as "line 3, column 5".
std::string position_of(const std::string& text, size_t byte) {
  const size_t end = std::min(byte > 0 ? byte - 1 : 0, text.size());
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<ptrdiff_t>(end), '\n');
  const size_t newline = end > 0 ? text.rfind('\n', end - 1) : std::string::npos;
  const size_t column = newline == std::string::npos ? end + 1 : end - newline;
  return fmt::format("line {}, column {}", line, column);
}

/// The parser's message without its own prefix and position.
std::string reason_of(const std::string& message) {
  const size_t syntax = message.find("syntax error");
  if (syntax != std::string::npos) return message.substr(syntax);
  const size_t bracket = message.find("] ");
  return bracket == std::string::npos ? message : message.substr(bracket + 2);
}

std::string escaped_pointer(std::string_view key) {
  std::string out;
  for (const char c : key) {
    if (c == '~') {
      out += "~0";
    } else if (c == '/') {
      out += "~1";
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace

JsonDocument::JsonDocument(const std::string& text, std::string file) : file_(std::move(file)) {
  if (text.size() > max_text_bytes) {
    throw limit_error(file_, fmt::format("{} bytes is too large", text.size()),
                      fmt::format("the limit is {} bytes", max_text_bytes));
  }
  try {
    value_ = std::make_unique<nlohmann::json>(
        nlohmann::json::parse(text, ParseWatch(file_), true, /*ignore_comments=*/true));
  } catch (const nlohmann::json::parse_error& e) {
    throw input_error(fmt::format("{}: {}", file_, position_of(text, e.byte)), reason_of(e.what()),
                      "mend the JSON there");
  } catch (const nlohmann::json::exception& e) {
    throw input_error(file_, reason_of(e.what()), "mend the JSON");
  }
}

JsonDocument::~JsonDocument() = default;

std::string JsonNode::place() const {
  return fmt::format("{}: {}", *file_, pointer_.empty() ? "/" : pointer_);
}

Error JsonNode::error(std::string_view what, std::string_view mend) const {
  return input_error(place(), what, mend);
}

bool JsonNode::is_object() const {
  return value_->is_object();
}
bool JsonNode::is_array() const {
  return value_->is_array();
}
bool JsonNode::is_string() const {
  return value_->is_string();
}
bool JsonNode::is_number() const {
  return value_->is_number();
}
bool JsonNode::is_boolean() const {
  return value_->is_boolean();
}

JsonNode JsonNode::child(const nlohmann::json& value, std::string_view key) const {
  return {&value, file_, pointer_ + "/" + escaped_pointer(key)};
}

void JsonNode::expect_keys(std::initializer_list<std::string_view> keys) const {
  check_keys(keys.begin(), keys.size());
}

void JsonNode::expect_keys(const std::vector<std::string_view>& keys) const {
  check_keys(keys.data(), keys.size());
}

void JsonNode::check_keys(const std::string_view* keys, size_t count) const {
  if (!is_object()) throw error("is not an object", "give { ... }");
  for (const auto& [key, value] : value_->items()) {
    if (std::find(keys, keys + count, key) != keys + count) continue;
    throw child(value, key).error("is an unknown key", suggest(key, keys, count));
  }
}

std::optional<JsonNode> JsonNode::find(std::string_view key) const {
  if (!is_object()) throw error("is not an object", "give { ... }");
  const auto found = value_->find(std::string(key));
  if (found == value_->end()) return std::nullopt;
  return child(*found, key);
}

JsonNode JsonNode::get(std::string_view key, std::string_view mend) const {
  if (auto node = find(key)) return *node;
  throw error(fmt::format("lacks \"{}\"", key), mend);
}

std::vector<std::pair<std::string, JsonNode>> JsonNode::members() const {
  if (!is_object()) throw error("is not an object", "give { ... }");
  std::vector<std::pair<std::string, JsonNode>> out;
  for (const auto& [key, value] : value_->items()) out.emplace_back(key, child(value, key));
  return out;
}

std::vector<JsonNode> JsonNode::items(uint64_t limit) const {
  if (!is_array()) throw error("is not an array", "give [ ... ]");
  if (value_->size() > limit) {
    throw limit_error(place(), fmt::format("{} items are too many", value_->size()),
                      fmt::format("the limit is {}", limit));
  }
  std::vector<JsonNode> out;
  out.reserve(value_->size());
  for (const nlohmann::json& value : *value_)
    out.push_back(child(value, fmt::to_string(out.size())));
  return out;
}

bool JsonNode::boolean() const {
  if (!is_boolean()) throw error("is not true or false", "give true or false");
  return value_->get<bool>();
}

float JsonNode::number(float low, float high) const {
  if (!is_number()) {
    throw error("is not a number", fmt::format("give a number within [{:g}, {:g}]", low, high));
  }
  const double value = value_->get<double>();
  if (!(value >= low && value <= high)) {
    throw error(fmt::format("{:g} is out of range", value),
                fmt::format("give a number within [{:g}, {:g}]", low, high));
  }
  return static_cast<float>(value);
}

int64_t JsonNode::integer(int64_t low, int64_t high) const {
  const std::string mend = fmt::format("give a whole number within [{}, {}]", low, high);
  if (!is_number()) throw error("is not a number", mend);
  const double value = value_->get<double>();
  if (value != std::floor(value))
    throw error(fmt::format("{:g} is not a whole number", value), mend);
  if (!(value >= static_cast<double>(low) && value <= static_cast<double>(high))) {
    throw error(fmt::format("{:.17g} is out of range", value), mend);
  }
  return value_->is_number_integer() ? value_->get<int64_t>() : static_cast<int64_t>(value);
}

uint64_t JsonNode::count(uint64_t low, uint64_t limit) const {
  const auto value = static_cast<uint64_t>(integer(static_cast<int64_t>(low), int64_t{1} << 53));
  if (value > limit) {
    throw limit_error(place(), fmt::format("{} is too many", value),
                      fmt::format("the limit is {}", limit));
  }
  return value;
}

std::string JsonNode::text(size_t max_length) const {
  if (!is_string()) throw error("is not a string", "give a text in double quotes");
  const auto& text = value_->get_ref<const std::string&>();
  if (text.empty()) throw error("is empty", "give a text");
  if (text.size() > max_length) {
    throw limit_error(place(), fmt::format("{} bytes are too long", text.size()),
                      fmt::format("the limit is {}", max_length));
  }
  const bool clean = std::none_of(text.begin(), text.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
  });
  if (!clean) throw error("holds a control character", "remove it");
  return text;
}

vec2 JsonNode::pair(float low, float high) const {
  if (!is_array() || value_->size() != 2)
    throw error("is not a list of two numbers", "give [a, b]");
  const std::vector<JsonNode> parts = items(2);
  return {parts[0].number(low, high), parts[1].number(low, high)};
}

vec3 JsonNode::vector(float low, float high) const {
  if (!is_array() || value_->size() != 3) {
    throw error("is not a list of three numbers", "give [x, y, z]");
  }
  const std::vector<JsonNode> parts = items(3);
  for (const JsonNode& part : parts) {
    if (part.is_number()) continue;
    throw part.error("is not a number",
                     fmt::format("give three numbers within [{:g}, {:g}]", low, high));
  }
  return {parts[0].number(low, high), parts[1].number(low, high), parts[2].number(low, high)};
}

void JsonNode::read(std::string_view key, bool& value) const {
  if (const auto node = find(key)) value = node->boolean();
}

void JsonNode::read(std::string_view key, float& value, float low, float high) const {
  if (const auto node = find(key)) value = node->number(low, high);
}

void JsonNode::read(std::string_view key, vec3& value, float low, float high) const {
  if (const auto node = find(key)) value = node->vector(low, high);
}

void JsonNode::read(std::string_view key, std::string& value, size_t max_length) const {
  if (const auto node = find(key)) value = node->text(max_length);
}

void JsonNode::read_seed(std::string_view key, uint64_t& value) const {
  if (const auto node = find(key)) {
    value = static_cast<uint64_t>(node->integer(0, int64_t{1} << 53));
  }
}

std::string json_quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string json_number(float value) {
  // JSON readers take "-0" as an integer, which has no negative zero.
  return value == 0 && std::signbit(value) ? "-0.0" : fmt::format("{}", value);
}

std::string json_vector(vec3 v) {
  return fmt::format("[{}, {}, {}]", json_number(v.x), json_number(v.y), json_number(v.z));
}

}  // namespace relume
