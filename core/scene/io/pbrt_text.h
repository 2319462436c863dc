#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/math/vec.h"

namespace relume {

/// One parameter: "float radius" [1]. Numbers are finite; true and false count as texts.
struct PbrtParameter {
  std::string type;
  std::string name;
  std::vector<double> numbers;
  std::vector<std::string> texts;
};

/// The parameters of a statement. Getters take the fallback where a parameter is missing and throw
/// Error(input) where it has the wrong type or count.
class PbrtParameters {
 public:
  std::string place;  ///< "FILE:LINE" of the statement
  std::vector<PbrtParameter> list;

  const PbrtParameter* find(std::string_view name) const;
  bool has(std::string_view name) const { return find(name) != nullptr; }
  double number(std::string_view name, double fallback) const;
  int64_t integer(std::string_view name, int64_t fallback) const;
  vec3 vector(std::string_view name, vec3 fallback) const;
  std::string text(std::string_view name, const std::string& fallback) const;
  bool flag(std::string_view name, bool fallback) const;
  /// All numbers of a parameter, a multiple of `width` of them; empty where it is missing.
  std::span<const double> numbers(std::string_view name, size_t width) const;

  [[noreturn]] void fail(std::string_view what, std::string_view mend) const {
    throw input_error(place, what, mend);
  }
};

/// One statement: Shape "curve" "point3 P" [...].
struct PbrtStatement {
  std::string name;
  std::vector<std::string> words;  ///< quoted, before the parameters
  std::vector<double> numbers;     ///< of transforms
  PbrtParameters parameters;
};

/// Reads the statements of a pbrt-v3 or -v4 scene file and of those that it includes. Unknown
/// statements, wrong numbers of arguments, numbers that are not finite, includes that are missing,
/// more than 32 deep or more than 10,000 together throw Error(input or limit) as "FILE:LINE: ...".
class PbrtReader {
 public:
  explicit PbrtReader(const std::filesystem::path& path);
  ~PbrtReader();

  /// The next statement, or nothing at the end.
  std::optional<PbrtStatement> next();

 private:
  struct Source;
  struct Token;
  Token take();
  Token look();
  void include(const std::string& name, const std::string& place);
  PbrtStatement read_statement(const Token& name);
  void read_words(int count, PbrtStatement& statement);
  void read_numbers(int count, PbrtStatement& statement);
  void read_parameters(PbrtStatement& statement);
  PbrtParameter read_parameter(const Token& head);
  void add_value(const Token& token, PbrtParameter& parameter) const;
  double number_of(const Token& token) const;
  std::string place() const;

  std::filesystem::path folder_;
  std::vector<std::unique_ptr<Source>> sources_;  ///< the last is being read
  int included_ = 0;
};

/// `name` as a file beside the scene that `folder` holds, or beside the file that names it.
std::filesystem::path pbrt_file(const std::filesystem::path& folder, const std::string& name,
                                const std::string& place);

}  // namespace relume
