#include "core/image/exr_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>
#include <vector>

namespace relume {
namespace {

constexpr uint32_t magic = 20000630;
constexpr uint32_t tiled_flag = 0x200;
constexpr uint32_t deep_flag = 0x800;
constexpr uint32_t multipart_flag = 0x1000;
constexpr size_t max_name_length = 255;
constexpr int max_parts = 64;
constexpr int max_attributes = 4096;
/// Deflate packs a byte into no less than a thousandth.
constexpr uint64_t most_packing = 1100;
/// Scanlines of a chunk, by the number of the compression: none, RLE, ZIPS, ZIP, PIZ, PXR24, B44,
/// B44A, DWAA, DWAB.
constexpr std::array<int, 10> chunk_lines = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};

struct SizedType {
  std::string_view name;
  size_t bytes;
};
/// Types whose values OpenEXR reads without a look at the size that the file gives.
constexpr SizedType sized_types[] = {{"box2i", 16},      {"box2f", 16},   {"chromaticities", 32},
                                     {"compression", 1}, {"double", 8},   {"envmap", 1},
                                     {"float", 4},       {"int", 4},      {"keycode", 28},
                                     {"lineOrder", 1},   {"m33f", 36},    {"m33d", 72},
                                     {"m44f", 64},       {"m44d", 128},   {"rational", 8},
                                     {"tiledesc", 9},    {"timecode", 8}, {"v2i", 8},
                                     {"v2f", 8},         {"v2d", 16},     {"v3i", 12},
                                     {"v3f", 12},        {"v3d", 24}};

/// Reads from the front; what is not there is nothing.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : left_(bytes) {}

  size_t left() const { return left_.size(); }

  template <class T>
  std::optional<T> number() {
    if (left_.size() < sizeof(T)) return {};
    T value;
    std::memcpy(&value, left_.data(), sizeof(T));
    left_ = left_.subspan(sizeof(T));
    return value;
  }

  /// Up to a zero byte.
  std::optional<std::string_view> name() {
    const size_t most = std::min(left_.size(), max_name_length + 1);
    const auto* text = reinterpret_cast<const char*>(left_.data());
    const void* end = std::memchr(text, 0, most);
    if (end == nullptr) return {};
    const std::string_view found(text, static_cast<size_t>(static_cast<const char*>(end) - text));
    left_ = left_.subspan(found.size() + 1);
    return found;
  }

  std::optional<std::span<const std::byte>> bytes(size_t count) {
    if (left_.size() < count) return {};
    const auto found = left_.first(count);
    left_ = left_.subspan(count);
    return found;
  }

 private:
  std::span<const std::byte> left_;
};

/// What the header says of a part.
struct Part {
  std::array<int32_t, 4> window{0, 0, -1, -1};  ///< first and last x and y, as x, y, x, y
  std::array<uint32_t, 2> tile{0, 0};
  uint8_t compression = 0;
  bool is_tiled = false;
  bool is_deep = false;

  int64_t width() const { return int64_t{window[2]} - window[0] + 1; }
  int64_t height() const { return int64_t{window[3]} - window[1] + 1; }
};

std::string check_preview(Reader value, size_t size) {
  const auto width = value.number<uint32_t>();
  const auto height = value.number<uint32_t>();
  if (!width || !height) return "its preview is cut short";
  if (*width > 65535 || *height > 65535 || 8 + uint64_t{*width} * *height * 4 != size) {
    return fmt::format("its preview of {} x {} pixels takes {} bytes", *width, *height, size);
  }
  return {};
}

/// A list of channels: names, each with the type of its values (0 to 2) and 12 bytes more, up to an
/// empty one. OpenImageIO ends the program for another type.
std::string check_channels(Reader value) {
  while (true) {
    const auto name = value.name();
    if (!name) return "its list of channels is cut short";
    if (name->empty()) break;
    const auto type = value.number<uint32_t>();
    if (!type || !value.bytes(12)) return "its list of channels is cut short";
    if (*type > 2) return fmt::format("a channel's values are of type {}, which is none", *type);
  }
  return value.left() == 0 ? "" : "its list of channels ends before its size";
}

std::string check_strings(Reader value) {
  while (value.left() > 0) {
    const auto length = value.number<int32_t>();
    if (!length || *length < 0 || !value.bytes(static_cast<size_t>(*length))) {
      return "a list of words in its header is cut short";
    }
  }
  return {};
}

/// Takes over what the attribute says; returns what is wrong.
std::string read_attribute(std::string_view name, std::string_view type, Reader value, size_t size,
                           Part& part) {
  const auto sized = std::ranges::find(sized_types, type, &SizedType::name);
  if (sized != std::end(sized_types) && sized->bytes != size) {
    return fmt::format("its header gives a {} {} bytes", type, size);
  }
  if (type == "preview") return check_preview(value, size);
  if (type == "chlist") return check_channels(value);
  if (type == "stringvector") return check_strings(value);
  if (name == "dataWindow" && type == "box2i") {
    for (int32_t& side : part.window) side = value.number<int32_t>().value_or(0);
  } else if (name == "compression" && size == 1) {
    part.compression = value.number<uint8_t>().value_or(0);
    if (part.compression >= chunk_lines.size()) {
      return fmt::format("its compression {} is none that we know", part.compression);
    }
  } else if (name == "type" && type == "string") {
    const auto text = value.bytes(size).value_or(std::span<const std::byte>());
    part.is_deep |= std::string_view(reinterpret_cast<const char*>(text.data()), text.size())
                        .starts_with("deep");
  } else if (name == "tiles" && type == "tiledesc") {
    part.is_tiled = true;
    for (uint32_t& side : part.tile) side = value.number<uint32_t>().value_or(0);
  }
  return {};
}

/// Chunks of the part's largest level: that many offsets stand in the file.
int64_t count_chunks(const Part& part) {
  const auto parts = [](int64_t whole, int64_t piece) { return (whole + piece - 1) / piece; };
  if (part.is_tiled) return parts(part.width(), part.tile[0]) * parts(part.height(), part.tile[1]);
  return parts(part.height(), chunk_lines[part.compression]);
}

std::optional<ExrFault> check_part(const Part& part, int max_size_px) {
  if (part.width() < 1 || part.height() < 1) return ExrFault{"it has no pixels"};
  if (part.width() > max_size_px || part.height() > max_size_px) {
    return ExrFault{fmt::format("{} x {} pixels is too large", part.width(), part.height()), true};
  }
  const auto most = static_cast<uint32_t>(max_size_px);
  if (part.is_tiled &&
      (part.tile[0] < 1 || part.tile[1] < 1 || part.tile[0] > most || part.tile[1] > most)) {
    return ExrFault{
        fmt::format("its tiles of {} x {} pixels make no sense", part.tile[0], part.tile[1])};
  }
  return {};
}

/// One part's attributes. `is_end`: there is none, as after the last part.
std::string read_part(Reader& reader, Part& part, bool& is_end) {
  for (int count = 0; count < max_attributes; ++count) {
    const auto name = reader.name();
    if (!name) return "its header is cut short or a name in it too long";
    if (name->empty()) {
      is_end = count == 0;
      return {};
    }
    const auto type = reader.name();
    const auto size = reader.number<int32_t>();
    if (!type || !size) return "its header is cut short or a name in it too long";
    const auto value = *size >= 0 ? reader.bytes(static_cast<size_t>(*size)) : std::nullopt;
    if (!value) return fmt::format("its header holds {} bytes that are not there", *size);
    std::string fault = read_attribute(*name, *type, Reader(*value), value->size(), part);
    if (!fault.empty()) return fault;
  }
  return "its header has too many attributes";
}

/// Blocks of deep pixels say how much they hold packed and unpacked; OpenEXR takes memory for both.
std::string check_deep_blocks(std::span<const std::byte> file, Reader offsets, int64_t chunks,
                              bool is_multipart, bool is_tiled) {
  for (int64_t i = 0; i < chunks; ++i) {
    const uint64_t offset = offsets.number<uint64_t>().value_or(0);
    if (offset == 0 || offset >= file.size()) return "blocks of its deep pixels are missing";
    Reader block(file.subspan(offset));
    block.bytes((is_multipart ? 4 : 0) + (is_tiled ? 16 : 4));
    const uint64_t packed_counts = block.number<uint64_t>().value_or(~uint64_t{0});
    const uint64_t packed_samples = block.number<uint64_t>().value_or(~uint64_t{0});
    const uint64_t samples = block.number<uint64_t>().value_or(~uint64_t{0});
    if (packed_counts > block.left() || packed_samples > block.left() - packed_counts ||
        samples / most_packing > packed_samples) {
      return "a block of its deep pixels is larger than the file can hold";
    }
  }
  return {};
}

}  // namespace

std::optional<ExrFault> find_exr_fault(std::span<const std::byte> file, int max_size_px) {
  Reader reader(file);
  const auto first = reader.number<uint32_t>();
  const auto version = reader.number<uint32_t>();
  if (first != magic || !version) return {};
  const bool is_multipart = (*version & multipart_flag) != 0;
  int64_t chunks = 0;
  std::vector<Part> parts;
  for (int count = 0;; ++count) {
    Part part;
    part.is_tiled = (*version & tiled_flag) != 0;
    part.is_deep = !is_multipart && (*version & deep_flag) != 0;
    bool is_end = false;
    if (count == max_parts) return ExrFault{"it has too many parts"};
    std::string fault = read_part(reader, part, is_end);
    if (!fault.empty()) return ExrFault{std::move(fault)};
    if (is_end && is_multipart && count > 0) break;
    if (auto part_fault = check_part(part, max_size_px)) return part_fault;
    chunks += count_chunks(part);
    parts.push_back(part);
    if (!is_multipart) break;
  }
  if (static_cast<uint64_t>(chunks) * sizeof(uint64_t) > reader.left()) {
    return ExrFault{fmt::format("it is too short for its {} blocks of pixels", chunks)};
  }
  for (const Part& part : parts) {
    const int64_t own = count_chunks(part);
    if (part.is_deep) {
      std::string fault = check_deep_blocks(file, reader, own, is_multipart, part.is_tiled);
      if (!fault.empty()) return ExrFault{std::move(fault)};
    }
    reader.bytes(static_cast<size_t>(own) * sizeof(uint64_t));
  }
  return {};
}

}  // namespace relume
