#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace relume {

/// What went wrong in the outside world. The values are the program's exit codes.
enum class ErrorKind : int {
  usage = 2,        ///< the command line does not make sense
  input = 3,        ///< a file is unreadable, corrupt or says something impossible
  limit = 4,        ///< a count or size is above what we accept
  output = 5,       ///< a file could not be written
  cancelled = 130,  ///< the user interrupted the work
};

/// The one exception for failures that come from outside (files, flags, limits). Its message is one
/// line: place, what is wrong, and the mend. Thrown where the failure is seen, caught in main or in
/// the viewer's session. Broken internal contracts use CHECK instead.
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}

  ErrorKind kind() const { return kind_; }
  int exit_code() const { return static_cast<int>(kind_); }

 private:
  ErrorKind kind_;
};

/// An ErrorKind::input Error that reads "PLACE: WHAT; MEND". `place` is a file, with a line or
/// field where there is one ("scene.json: /materials/2/diffuse"). Contents that come from a hostile
/// file are shortened and stripped of control characters.
Error input_error(std::string_view place, std::string_view what, std::string_view mend);

/// Same shape, with exit code 4: a count, size or depth above a limit of ours.
Error limit_error(std::string_view place, std::string_view what, std::string_view mend);

/// Same shape, with exit code 5: a file could not be written.
Error output_error(std::string_view place, std::string_view what, std::string_view mend);

/// `text` with control characters and invalid UTF-8 replaced by '?' and cut, between characters, to
/// at most `max_length` bytes and "...", so that text from a hostile file is safe to print and to
/// store.
std::string printable(std::string_view text, size_t max_length = 200);

}  // namespace relume
