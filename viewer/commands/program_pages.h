#pragma once

#include <string>
#include <vector>

namespace relume {

struct OptionDescription {
  std::vector<std::string> names;  ///< {"-o", "--output"}; one name where positional
  std::string help;                ///< ends in ": a, b, c" where it takes one of these
  std::string initial;             ///< default value; may be empty
  bool is_positional = false;
  bool has_value = true;  ///< false: a flag
};

struct CommandDescription {
  std::string name;
  std::string help;
  std::string examples;  ///< "Examples:\n  relume ..."
  std::vector<OptionDescription> options{};
};

/// What the program says of itself.
struct ProgramDescription {
  std::string help;  ///< "Name: what it does"
  std::string exit_codes;
  std::vector<CommandDescription> commands;
};

/// The manual page of section 1, roff with the man macros; the same bytes every time.
std::string format_manual(const ProgramDescription& program);

/// A bash script that completes commands, options, their listed values and file names.
std::string format_bash_completion(const ProgramDescription& program);

/// The words that an option's help lists at its end (": none, ray, members"), or nothing.
std::vector<std::string> listed_values(const std::string& help);

}  // namespace relume
