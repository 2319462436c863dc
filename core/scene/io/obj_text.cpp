#include <fmt/format.h>

#include <charconv>

#include "core/base/error.h"
#include "core/scene/io/obj_parts.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

/// Cuts a text into lines at "\n", "\r\n" and "\r".
class LineReader {
 public:
  explicit LineReader(std::string_view text) : rest_(text) {}

  bool next() {
    if (rest_.empty()) return false;
    const size_t end = rest_.find_first_of("\r\n");
    ended_ = end != std::string_view::npos;
    line_ = rest_.substr(0, end);
    const bool crlf =
        ended_ && rest_[end] == '\r' && end + 1 < rest_.size() && rest_[end + 1] == '\n';
    rest_.remove_prefix(ended_ ? end + (crlf ? 2 : 1) : rest_.size());
    ++number_;
    return true;
  }
  std::string_view line() const { return line_; }
  uint64_t number() const { return number_; }
  bool ended() const { return ended_; }  ///< by a line end, not by the end of the text

 private:
  std::string_view rest_;
  std::string_view line_;
  uint64_t number_ = 0;
  bool ended_ = true;
};

/// Takes words off the front of a line, up to a comment.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}

  std::string_view next() {
    while (!rest_.empty() && is_blank(rest_.front())) rest_.remove_prefix(1);
    if (!rest_.empty() && rest_.front() == '#') rest_ = {};
    const size_t end = std::min(rest_.find_first_of(" \t"), rest_.size());
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(end);
    return word;
  }
  std::string_view rest() const { return trimmed(rest_); }

 private:
  std::string_view rest_;
};

/// Parses all of `word`; false when it is no number of type T.
template <class T>
bool parse_number(std::string_view word, T& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size() && !word.empty();
}

/// Shared by the two checkers: where we are, and how to complain.
class TextChecker {
 protected:
  TextChecker(std::string_view text, const std::string& file) : lines_(text), file_(file) {
    if (text.find('\0') != std::string_view::npos) {
      throw input_error(file_, "holds zero bytes: it is not a text file", "check the file");
    }
  }

  [[noreturn]] void fail(std::string_view what, std::string_view mend) const {
    fail_at(lines_.number(), what, mend);
  }
  [[noreturn]] void fail_at(uint64_t line, std::string_view what, std::string_view mend) const {
    throw input_error(fmt::format("{}:{}", file_, line), what, mend);
  }

  /// `low` to `high` numbers of at most `limit`, up to the end of the line.
  void check_numbers(Words words, int low, int high, double limit) const {
    int count = 0;
    for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++count) {
      double value = 0;
      if (!parse_number(word, value)) {
        fail(fmt::format("\"{}\" is not a number", word), "mend the number or remove the line");
      }
      if (!(std::abs(value) <= limit)) {
        fail(fmt::format("{} is not finite or too large", word),
             fmt::format("give numbers within [{:g}, {:g}]", -limit, limit));
      }
    }
    if (count < low || count > high) {
      const std::string belong =
          low == high ? fmt::to_string(low) : fmt::format("{} to {}", low, high);
      fail(fmt::format("{} numbers where {} belong", count, belong),
           "mend the line; the file may be cut short");
    }
  }

  LineReader lines_;
  const std::string& file_;
};

class ObjChecker : public TextChecker {
 public:
  ObjChecker(std::string_view text, const std::string& file)
      : TextChecker(text, file), index_bound_(text.size()) {}

  ObjSummary run() {
    bool cut = false;
    while (lines_.next()) {
      Words words(lines_.line());
      const std::string_view keyword = words.next();
      if (keyword.empty()) continue;
      const bool geometry = check_statement(keyword, words);
      cut = geometry && !lines_.ended();
    }
    check_indices("vertex", position_, summary_.positions);
    check_indices("texture coordinate", uv_, summary_.uvs);
    check_indices("normal", normal_, summary_.normals);
    if (summary_.faces == 0) {
      throw input_error(file_, "holds no faces", "check that the file is complete");
    }
    if (cut && used_count_ < summary_.positions) {
      fail("the last line has no end and some vertices no face: the file seems cut short",
           "get the whole file; if it is whole, end its last line");
    }
    return std::move(summary_);
  }

 private:
  /// The largest index seen of one kind, and where.
  struct Largest {
    int64_t index = 0;
    uint64_t line = 0;
  };

  /// True for a line of geometry.
  bool check_statement(std::string_view keyword, Words words) {
    const bool geometry = keyword == "v" || keyword == "vt" || keyword == "vn" || keyword == "f";
    if (geometry && lines_.line().back() == '\\') {
      fail("continues on the next line", "join the two lines: continuations are not supported");
    }
    if (keyword == "v") {
      check_numbers(words, 3, 8, max_coordinate);
      ++summary_.positions;
    } else if (keyword == "vt") {
      check_numbers(words, 1, 3, max_coordinate);
      ++summary_.uvs;
    } else if (keyword == "vn") {
      check_numbers(words, 3, 3, max_coordinate);
      ++summary_.normals;
    } else if (keyword == "f") {
      check_face(words);
    } else {
      check_other(keyword, words);
    }
    if (summary_.positions > INT32_MAX || summary_.uvs > INT32_MAX ||
        summary_.normals > INT32_MAX) {
      throw limit_error(file_, "more than 2147483647 vertices", "split the file");
    }
    return geometry;
  }

  void check_other(std::string_view keyword, Words words) {
    if (keyword == "mtllib") {
      summary_.material_files.emplace_back(words.rest());
      return;
    }
    // Groups, lines, points and free-form curves: known, not used here.
    static constexpr std::array<std::string_view, 39> ignored{
        "usemtl",    "g",      "o",      "s",      "l",     "p",        "fo",       "vp",
        "vw",        "mg",     "t",      "lod",    "bevel", "c_interp", "d_interp", "shadow_obj",
        "trace_obj", "usemap", "maplib", "cstype", "deg",   "bmat",     "step",     "curv",
        "curv2",     "surf",   "parm",   "trim",   "hole",  "scrv",     "sp",       "end",
        "con",       "ctech",  "stech",  "bsp",    "bzp",   "cdc",      "cdp"};
    if (std::find(ignored.begin(), ignored.end(), keyword) != ignored.end()) return;
    fail(fmt::format("\"{}\" is no OBJ statement", printable(keyword, 40)),
         "check that this is an OBJ file, whole and not damaged");
  }

  void check_face(Words words) {
    int shape = -1;
    uint64_t corners = 0;
    for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++corners) {
      const int own_shape = check_corner(word);
      if (corners > 0 && own_shape != shape) {
        fail(fmt::format("corner \"{}\" has other parts than those before it", word),
             "give each corner of a face the same parts");
      }
      shape = own_shape;
    }
    if (corners < 3) {
      fail(fmt::format("a face of {} corners", corners),
           "give at least three; the file may be cut short");
    }
    ++summary_.faces;
    summary_.corners += corners;
  }

  /// Checks "v", "v/t", "v//n" or "v/t/n"; returns which of them it is.
  int check_corner(std::string_view word) {
    std::array<std::string_view, 3> parts;
    size_t count = 0;
    for (size_t begin = 0; begin <= word.size() && count < 3; ++count) {
      const size_t end = std::min(word.find('/', begin), word.size());
      parts[count] = word.substr(begin, end - begin);
      begin = end + 1;
    }
    const auto slashes = static_cast<size_t>(std::count(word.begin(), word.end(), '/'));
    const bool fits = slashes + 1 == count && !parts[0].empty() && !parts[count - 1].empty();
    if (!fits) bad_corner(word);
    mark_used(check_index(parts[0], word, summary_.positions, position_));
    if (count > 1 && !parts[1].empty()) check_index(parts[1], word, summary_.uvs, uv_);
    if (count > 2) check_index(parts[2], word, summary_.normals, normal_);
    return static_cast<int>(count) * 2 + (count > 1 && parts[1].empty() ? 1 : 0);
  }

  [[noreturn]] void bad_corner(std::string_view word) const {
    fail(fmt::format("\"{}\" is not a face corner", printable(word, 40)),
         "give v, v/t, v//n or v/t/n; the file may be cut short");
  }

  /// Returns the index from 0 that `part` names.
  uint64_t check_index(std::string_view part, std::string_view word, uint64_t so_far,
                       Largest& largest) {
    int64_t index = 0;
    if (!parse_number(part, index) || index == 0) bad_corner(word);
    if (index < 0) {
      if (index < -static_cast<int64_t>(so_far)) {
        fail(fmt::format("index {} points before the first of {}", index, so_far),
             "mend the index");
      }
      return so_far - static_cast<uint64_t>(-index);
    }
    if (index > largest.index) largest = {index, lines_.number()};
    // No file has more vertices than bytes: what is above cannot be, and is not remembered.
    if (static_cast<uint64_t>(index) > index_bound_) {
      fail(fmt::format("index {} is beyond the end of the file's lists", index),
           "mend the index; the file may be cut short");
    }
    return static_cast<uint64_t>(index) - 1;
  }

  void mark_used(uint64_t index) {
    if (index >= used_.size()) used_.resize(std::max<uint64_t>(index + 1, 2 * used_.size()));
    if (!used_[index]) {
      used_[index] = true;
      ++used_count_;
    }
  }

  void check_indices(std::string_view kind, const Largest& largest, uint64_t count) const {
    if (largest.index <= static_cast<int64_t>(count)) return;
    fail_at(largest.line, fmt::format("refers to {} {} of {}", kind, largest.index, count),
            "mend the index; the file may be cut short");
  }

  ObjSummary summary_;
  uint64_t index_bound_;
  Largest position_;
  Largest uv_;
  Largest normal_;
  std::vector<bool> used_;
  uint64_t used_count_ = 0;
};

class MtlChecker : public TextChecker {
 public:
  MtlChecker(std::string_view text, const std::string& file) : TextChecker(text, file) {}

  void run() {
    while (lines_.next()) {
      Words words(lines_.line());
      const std::string_view keyword = words.next();
      if (keyword == "Kd" || keyword == "Ks" || keyword == "Ke") {
        check_numbers(words, 3, 3, 1e6);
      } else if (keyword == "Ns" || keyword == "d" || keyword == "Tr") {
        check_numbers(words, 1, 1, 1e6);
      } else if (keyword == "newmtl" || keyword == "map_Kd" || keyword == "map_d") {
        if (words.rest().empty()) fail(fmt::format("{} lacks a name", keyword), "give a name");
      }
    }
  }
};

}  // namespace

ObjSummary check_obj_text(std::string_view text, const std::string& file) {
  return ObjChecker(text, file).run();
}

void check_mtl_text(std::string_view text, const std::string& file) {
  MtlChecker(text, file).run();
}

}  // namespace relume
