#include "viewer/commands/program_pages.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "viewer/commands/version.h"

namespace relume {
namespace {

/// Text as roff reads it: no escapes, plain minus signs, no line that looks like a request.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const bool starts_line = out.empty() || out.back() == '\n';
    if (starts_line && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
  }
  return out;
}

std::string format_option(const OptionDescription& option) {
  std::string names;
  for (const std::string& name : option.names) {
    names += fmt::format("{}\\fB{}\\fR", names.empty() ? "" : ", ", roff(name));
  }
  if (option.has_value && !option.is_positional) names += " \\fIvalue\\fR";
  std::string text = roff(option.help);
  if (!option.initial.empty()) text += fmt::format(" (default {})", roff(option.initial));
  return fmt::format(".TP\n{}\n{}\n", names, text);
}

/// Options that every command has are told once.
bool is_common(const OptionDescription& option) {
  static const std::set<std::string> common = {"--help",  "--threads", "--seed",
                                               "--quiet", "--verbose", "--json"};
  return common.count(option.names.back()) > 0;
}

std::string format_command(const CommandDescription& command) {
  std::string out = fmt::format(".SS {}\n{}.\n", roff(command.name), roff(command.help));
  for (const OptionDescription& option : command.options) {
    if (!is_common(option)) out += format_option(option);
  }
  const size_t line = command.examples.find('\n');
  if (line != std::string::npos) {
    out +=
        fmt::format(".PP\nExamples:\n.PP\n.nf\n{}\n.fi\n", roff(command.examples.substr(line + 1)));
  }
  return out;
}

/// A word that needs no quotes in a shell's list.
bool is_word(const std::string& text) {
  if (text.empty()) return false;
  return std::all_of(text.begin(), text.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' || c == '.';
  });
}

/// The lines of one command: its options, and the values that some of them take.
std::string complete_command(const CommandDescription& command) {
  std::vector<std::string> names;
  std::string values;
  for (const OptionDescription& option : command.options) {
    if (option.is_positional) continue;
    names.insert(names.end(), option.names.begin(), option.names.end());
    const std::vector<std::string> words = listed_values(option.help);
    if (words.empty()) continue;
    values += fmt::format("        {}) words=\"{}\" ;;\n", fmt::join(option.names, "|"),
                          fmt::join(words, " "));
  }
  std::string out =
      fmt::format("    {})\n      options=\"{}\"\n", command.name, fmt::join(names, " "));
  if (!values.empty()) out += fmt::format("      case $previous in\n{}      esac\n", values);
  return out + "      ;;\n";
}

}  // namespace

std::vector<std::string> listed_values(const std::string& help) {
  const size_t colon = help.rfind(": ");
  if (colon == std::string::npos) return {};
  std::vector<std::string> words;
  for (size_t at = colon + 2; at <= help.size();) {
    const size_t end = std::min(help.find(", ", at), help.size());
    words.push_back(help.substr(at, end - at));
    if (!is_word(words.back())) return {};
    at = end + 2;
  }
  return words.size() > 1 ? words : std::vector<std::string>{};
}

std::string format_manual(const ProgramDescription& program) {
  std::string out = fmt::format(
      ".TH RELUME 1 \"\" \"relume {}\" \"User Commands\"\n.SH NAME\nrelume \\- {}\n"
      ".SH SYNOPSIS\n.B relume\n\\fIcommand\\fR [\\fIoption\\fR ...]\n"
      ".SH DESCRIPTION\n{}.\nFigures go to standard output, progress and errors to standard "
      "error.\n.SH COMMON OPTIONS\n",
      relume_version, roff(program.help.substr(program.help.find(": ") + 2)), roff(program.help));
  for (const OptionDescription& option : program.commands.front().options) {
    if (is_common(option)) out += format_option(option);
  }
  out += ".SH COMMANDS\n";
  for (const CommandDescription& command : program.commands) out += format_command(command);
  return out + fmt::format(".SH EXIT STATUS\n{}\n", roff(program.exit_codes));
}

std::string format_bash_completion(const ProgramDescription& program) {
  std::vector<std::string> commands;
  std::string cases;
  for (const CommandDescription& command : program.commands) {
    commands.push_back(command.name);
    cases += complete_command(command);
  }
  return fmt::format(R"(# bash completion for relume
_relume() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD-1]}}
  local commands="{}" options="" words=""
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W "$commands" -- "$current"))
    return
  fi
  case ${{COMP_WORDS[1]}} in
{}  esac
  if [ -n "$words" ]; then
    COMPREPLY=($(compgen -W "$words" -- "$current"))
  elif [[ $current == -* ]]; then
    COMPREPLY=($(compgen -W "$options" -- "$current"))
  else
    COMPREPLY=($(compgen -f -- "$current"))
  fi
}}
complete -o filenames -F _relume relume
)",
                     fmt::join(commands, " "), cases);
}

}  // namespace relume
