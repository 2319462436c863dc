#pragma once

#include <initializer_list>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/base/label.h"
#include "core/math/vec.h"

namespace relume {

/// A value inside a JsonDocument that knows where it stands. Every getter checks type and range and
/// throws Error(input) as "scene.json: /materials/2/diffuse/1: what; mend". Valid while its
/// document lives.
class JsonNode {
 public:
  JsonNode(const nlohmann::json* value, const std::string* file, std::string pointer)
      : value_(value), file_(file), pointer_(std::move(pointer)) {}

  /// "scene.json: /materials/2".
  std::string place() const;
  Error error(std::string_view what, std::string_view mend) const;

  bool is_object() const;
  bool is_array() const;
  bool is_string() const;
  bool is_number() const;
  bool is_boolean() const;

  /// Requires an object with no other keys than these; names the nearest one for a misspelt key.
  void expect_keys(std::initializer_list<std::string_view> keys) const;
  void expect_keys(const std::vector<std::string_view>& keys) const;
  bool has(std::string_view key) const { return find(key).has_value(); }
  /// The member of an object, or nothing.
  std::optional<JsonNode> find(std::string_view key) const;
  /// The member of an object; `mend` says what to give when it is missing.
  JsonNode get(std::string_view key, std::string_view mend) const;
  /// The members of an object, in alphabetic order.
  std::vector<std::pair<std::string, JsonNode>> members() const;
  /// The items of an array; throws Error(limit) above `limit`.
  std::vector<JsonNode> items(uint64_t limit) const;

  bool boolean() const;
  float number(float low, float high) const;
  /// A whole number within [low, high].
  int64_t integer(int64_t low, int64_t high) const;
  /// A whole number >= low; throws Error(limit) above `limit`.
  uint64_t count(uint64_t low, uint64_t limit) const;
  /// A string of 1 to max_length bytes without control characters.
  std::string text(size_t max_length) const;
  /// An array of two or three numbers.
  vec2 pair(float low, float high) const;
  vec3 vector(float low, float high) const;
  template <class E, size_t N>
  E label(const std::array<Label<E>, N>& table) const;

  // Optional members: leave `value` alone when the key is absent.
  void read(std::string_view key, bool& value) const;
  void read(std::string_view key, float& value, float low, float high) const;
  void read(std::string_view key, vec3& value, float low, float high) const;
  void read(std::string_view key, std::string& value, size_t max_length) const;
  void read_seed(std::string_view key, uint64_t& value) const;
  template <class E, size_t N>
  void read(std::string_view key, E& value, const std::array<Label<E>, N>& table) const;

 private:
  JsonNode child(const nlohmann::json& value, std::string_view key) const;
  std::string expect(std::string_view what) const;
  void check_keys(const std::string_view* keys, size_t count) const;

  const nlohmann::json* value_;
  const std::string* file_;
  std::string pointer_;
};

/// A parsed JSON text. // and /* */ comments are allowed, duplicate keys are not.
class JsonDocument {
 public:
  /// `file` stands in messages. Throws Error(input) with line and column, and Error(limit) above 64
  /// MiB or 64 levels.
  JsonDocument(const std::string& text, std::string file);
  ~JsonDocument();
  JsonDocument(const JsonDocument&) = delete;
  JsonDocument& operator=(const JsonDocument&) = delete;

  JsonNode root() const { return {value_.get(), &file_, ""}; }

 private:
  std::unique_ptr<nlohmann::json> value_;
  std::string file_;
};

/// `text` as a JSON string, with its quotes.
std::string json_quoted(const std::string& text);

/// The shortest JSON number that reads back as the same float.
std::string json_number(float value);

/// `v` as a JSON list of three numbers.
std::string json_vector(vec3 v);

template <class E, size_t N>
E JsonNode::label(const std::array<Label<E>, N>& table) const {
  const std::string name = text(256);
  if (const std::optional<E> value = value_of(table, name)) return *value;
  throw error("\"" + name + "\" is unknown", "give one of: " + label_list(table));
}

template <class E, size_t N>
void JsonNode::read(std::string_view key, E& value, const std::array<Label<E>, N>& table) const {
  if (const auto node = find(key)) value = node->label(table);
}

}  // namespace relume
