#include "core/scene/io/ply_file.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <map>

#include "core/base/error.h"
#include "core/base/label.h"
#include "core/scene/io/packed_file.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

constexpr size_t max_header_bytes = 1 << 16;
constexpr uint64_t max_corners = 1024;

enum class Number { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

constexpr std::array number_names = {
    Label<Number>{Number::int8, "char"},      Label<Number>{Number::int8, "int8"},
    Label<Number>{Number::uint8, "uchar"},    Label<Number>{Number::uint8, "uint8"},
    Label<Number>{Number::int16, "short"},    Label<Number>{Number::int16, "int16"},
    Label<Number>{Number::uint16, "ushort"},  Label<Number>{Number::uint16, "uint16"},
    Label<Number>{Number::int32, "int"},      Label<Number>{Number::int32, "int32"},
    Label<Number>{Number::uint32, "uint"},    Label<Number>{Number::uint32, "uint32"},
    Label<Number>{Number::float32, "float"},  Label<Number>{Number::float32, "float32"},
    Label<Number>{Number::float64, "double"}, Label<Number>{Number::float64, "float64"},
};

size_t bytes_of(Number number) {
  constexpr size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return sizes[static_cast<size_t>(number)];
}

struct Property {
  std::string name;
  Number item = Number::float32;
  std::optional<Number> count;  ///< of a list
};

struct Element {
  std::string name;
  uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  enum class Format { ascii, little, big } format = Format::ascii;
  std::vector<Element> elements;
  size_t bytes = 0;
};

class HeaderReader {
 public:
  HeaderReader(std::string_view text, const std::string& file) : rest_(text), file_(file) {}

  Header read() {
    const size_t size = rest_.size();
    if (take_line() != std::vector<std::string>{"ply"}) fail("does not start with \"ply\"");
    bool has_format = false;
    for (auto words = take_line(); words != std::vector<std::string>{"end_header"};
         words = take_line()) {
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "format" && words.size() == 3) {
        read_format(words[1]);
        has_format = true;
      } else if (words[0] == "element" && words.size() == 3) {
        header_.elements.push_back({words[1], read_count(words[2]), {}});
      } else if (words[0] == "property" && !header_.elements.empty()) {
        read_property(words);
      } else {
        fail(fmt::format("its header has a line that starts with \"{}\"", words[0]));
      }
    }
    if (!has_format) fail("its header names no format");
    header_.bytes = size - rest_.size();
    return header_;
  }

 private:
  [[noreturn]] void fail(std::string_view what) const {
    throw input_error(file_, what, "give a PLY file");
  }

  std::vector<std::string> take_line() {
    const size_t end = rest_.substr(0, max_header_bytes).find('\n');
    if (end == std::string_view::npos) fail("its header does not end");
    std::vector<std::string> words;
    std::string word;
    for (const char c : rest_.substr(0, end + 1)) {
      const bool is_blank = c == ' ' || c == '\t' || c == '\r' || c == '\n';
      if (!is_blank) word += c;
      if (is_blank && !word.empty()) words.push_back(std::move(word));
      if (is_blank) word.clear();
    }
    rest_.remove_prefix(end + 1);
    if (++lines_ > 10'000) fail("its header does not end");
    return words;
  }

  void read_format(const std::string& name) {
    using Format = Header::Format;
    if (name == "ascii") {
      header_.format = Format::ascii;
    } else if (name == "binary_little_endian") {
      header_.format = Format::little;
    } else if (name == "binary_big_endian") {
      header_.format = Format::big;
    } else {
      fail(fmt::format("has the unknown format \"{}\"", name));
    }
  }

  uint64_t read_count(const std::string& word) const {
    uint64_t count = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), count);
    if (error != std::errc() || end != word.data() + word.size()) fail("a count is no number");
    return count;
  }

  Number read_number(const std::string& name) const {
    for (const auto& [number, label] : number_names) {
      if (label == name) return number;
    }
    fail(fmt::format("has a property of the unknown type \"{}\"", name));
  }

  void read_property(const std::vector<std::string>& words) {
    std::vector<Property>& properties = header_.elements.back().properties;
    if (words.size() == 3) {
      properties.push_back({words[2], read_number(words[1]), {}});
    } else if (words.size() == 5 && words[1] == "list") {
      properties.push_back({words[4], read_number(words[3]), read_number(words[2])});
    } else {
      fail("has a property that says too little or too much");
    }
  }

  std::string_view rest_;
  const std::string& file_;
  Header header_;
  int lines_ = 0;
};

class BodyReader {
 public:
  BodyReader(std::string_view body, const Header& header, const std::string& file)
      : rest_(body), header_(header), file_(file) {}

  IndexedMesh read() {
    for (const Element& element : header_.elements) {
      check_size(element);
      element_ = &element;
      for (index_ = 0; index_ < element.count; ++index_) read_item(element);
      if (element.name == "vertex") check_vertices();
    }
    const auto vertices = static_cast<uint32_t>(mesh_.positions.size());
    for (const uvec3 t : mesh_.triangles) {
      if (t.x < vertices && t.y < vertices && t.z < vertices) continue;
      throw input_error(
          file_,
          fmt::format("a face refers to vertex {} of {}", std::max({t.x, t.y, t.z}), vertices),
          "export the file again");
    }
    if (mesh_.triangles.empty()) throw input_error(file_, "has no faces", "check the file");
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(std::string_view what) const {
    throw input_error(fmt::format("{}: {} {}", file_, element_->name, index_), what,
                      "the file is cut short or damaged: copy it again");
  }

  /// Each item takes some bytes: so many cannot be there.
  void check_size(const Element& element) const {
    uint64_t least = 0;
    for (const Property& property : element.properties) {
      const Number first = property.count.value_or(property.item);
      least += header_.format == Header::Format::ascii ? 2 : bytes_of(first);
    }
    const uint64_t room = rest_.size() + 1;  // the last number of a text may end with it
    if (element.count == 0 || (least > 0 && element.count <= room / least)) return;
    throw input_error(file_,
                      fmt::format("says it has {} of element {}, and has {} bytes left",
                                  element.count, element.name, rest_.size()),
                      "the file is cut short or damaged: copy it again");
  }

  void read_item(const Element& element) {
    const bool is_vertex = element.name == "vertex";
    float values[8] = {};
    bool is_given[8] = {};
    for (const Property& property : element.properties) {
      if (property.count) {
        read_list(property, element.name == "face");
        continue;
      }
      const double value = take(property.item);
      const int slot = is_vertex ? slot_of(property.name) : -1;
      if (slot < 0) continue;
      values[slot] = static_cast<float>(value);
      is_given[slot] = true;
    }
    if (!is_vertex) return;
    if (!is_given[0] || !is_given[1] || !is_given[2]) fail("has no position");
    mesh_.positions.emplace_back(values[0], values[1], values[2]);
    if (!is_coordinate(mesh_.positions.back())) fail("is not finite or above 1e9");
    if (is_given[3] && is_given[4] && is_given[5]) {
      mesh_.normals.emplace_back(values[3], values[4], values[5]);
      if (!is_finite(mesh_.normals.back())) fail("has a normal that is not finite");
    }
    if (is_given[6] && is_given[7]) {
      mesh_.uvs.emplace_back(values[6], values[7]);
      if (!is_finite(mesh_.uvs.back())) fail("has a uv that is not finite");
    }
  }

  static int slot_of(const std::string& name) {
    static const std::map<std::string, int, std::less<>> slots{
        {"x", 0}, {"y", 1}, {"z", 2}, {"nx", 3}, {"ny", 4},        {"nz", 5},
        {"u", 6}, {"v", 7}, {"s", 6}, {"t", 7},  {"texture_u", 6}, {"texture_v", 7}};
    const auto found = slots.find(name);
    return found == slots.end() ? -1 : found->second;
  }

  void read_list(const Property& property, bool is_face) {
    const double count = take(*property.count);
    const bool is_polygon =
        is_face && (property.name == "vertex_indices" || property.name == "vertex_index");
    const auto most = static_cast<double>(is_polygon ? max_corners : rest_.size());
    if (!(count >= 0 && count <= most)) {
      fail(fmt::format("has a list of {} numbers", count));
    }
    uint32_t corners[2] = {};
    for (uint64_t i = 0; i < static_cast<uint64_t>(count); ++i) {
      const double value = take(property.item);
      if (!is_polygon) continue;
      if (!(value >= 0 && value < 4294967295.0)) fail(fmt::format("refers to vertex {}", value));
      const auto corner = static_cast<uint32_t>(value);
      if (i >= 2) add_triangle({corners[0], corners[1], corner});
      corners[i == 0 ? 0 : 1] = corner;
    }
  }

  void add_triangle(uvec3 triangle) {
    if (mesh_.triangles.size() >= max_triangles) {
      throw limit_error(file_, "too many triangles", fmt::format("the limit is {}", max_triangles));
    }
    mesh_.triangles.push_back(triangle);
  }

  void check_vertices() {
    if (mesh_.normals.size() != mesh_.positions.size()) mesh_.normals.clear();
    if (mesh_.uvs.size() != mesh_.positions.size()) mesh_.uvs.clear();
  }

  double take(Number number) {
    return header_.format == Header::Format::ascii ? take_text() : take_bytes(number);
  }

  double take_text() {
    const size_t start = std::min(rest_.find_first_not_of(" \t\r\n"), rest_.size());
    rest_.remove_prefix(start);
    double value = 0;
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    if (error != std::errc()) fail("has no number where one should be");
    rest_.remove_prefix(static_cast<size_t>(end - rest_.data()));
    return value;
  }

  double take_bytes(Number number) {
    const size_t size = bytes_of(number);
    if (rest_.size() < size) fail("ends early");
    char bytes[8];
    std::memcpy(bytes, rest_.data(), size);
    rest_.remove_prefix(size);
    const bool is_big = header_.format == Header::Format::big;
    if (is_big != (std::endian::native == std::endian::big)) std::reverse(bytes, bytes + size);
    switch (number) {
      case Number::int8:
        return load<int8_t>(bytes);
      case Number::uint8:
        return load<uint8_t>(bytes);
      case Number::int16:
        return load<int16_t>(bytes);
      case Number::uint16:
        return load<uint16_t>(bytes);
      case Number::int32:
        return load<int32_t>(bytes);
      case Number::uint32:
        return load<uint32_t>(bytes);
      case Number::float32:
        return load<float>(bytes);
      case Number::float64:
        return load<double>(bytes);
    }
    return 0;
  }

  template <class T>
  static T load(const char* bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof(value));
    return value;
  }

  std::string_view rest_;
  const Header& header_;
  const std::string& file_;
  const Element* element_ = nullptr;
  uint64_t index_ = 0;
  IndexedMesh mesh_;
};

}  // namespace

IndexedMesh read_ply(const std::filesystem::path& path) {
  const std::string file = path.string();
  const PackedFile packed(path);
  const std::string_view text = packed.text();
  const Header header = HeaderReader(text, file).read();
  return BodyReader(text.substr(header.bytes), header, file).read();
}

}  // namespace relume
