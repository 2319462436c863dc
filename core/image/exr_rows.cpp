#include "core/image/exr_rows.h"

#include <OpenImageIO/deepdata.h>
#include <fmt/format.h>

#include <cstring>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/mapped_file.h"
#include "core/image/exr_header.h"
#include "core/image/image_input.h"
#include "core/image/scanlines.h"

namespace relume {
namespace {

constexpr int max_flat_px = 65536;
constexpr int max_deep_px = 16384;
constexpr int max_channels = 1024;
constexpr uint64_t max_value_bytes = uint64_t{8} << 30;
/// Pixels of a row may not hold more; also what keeps a broken file from asking for all memory.
constexpr uint64_t max_row_samples = uint64_t{1} << 26;
/// Flat pixels pass through memory in bands of about this many values.
constexpr size_t band_values = size_t{1} << 22;

Error unreadable(const std::filesystem::path& path, const std::string& reason) {
  return input_error(path.string(), "cannot read the image: " + one_line(reason),
                     "check that the file is complete");
}

bool is_exr(std::span<const std::byte> bytes) {
  constexpr std::array<uint8_t, 4> magic = {0x76, 0x2f, 0x31, 0x01};
  return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

void check_file(const std::filesystem::path& path) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) {
    throw input_error(path.string(), "cannot open: there is no such file", "check the path");
  }
  const MappedFile file(path);
  if (!is_exr(file.bytes())) throw input_error(path.string(), "is no OpenEXR file", "give an EXR");
  const auto fault = find_exr_fault(file.bytes(), max_flat_px);
  if (!fault) return;
  if (!fault->is_too_large) throw unreadable(path, fault->what);
  throw limit_error(path.string(), fault->what, fmt::format("the limit is {0} x {0}", max_flat_px));
}

void check_spec(const std::filesystem::path& path, const OIIO::ImageSpec& spec) {
  if (spec.deep && spec.tile_width > 0) {
    throw input_error(path.string(), "is tiled", "write deep scanlines");
  }
  if (spec.depth > 1) throw input_error(path.string(), "is a volume", "give a flat or deep image");
  const int limit = spec.deep ? max_deep_px : max_flat_px;
  for (const int size : {spec.width, spec.height, spec.full_width, spec.full_height}) {
    if (size >= 1 && size <= limit) continue;
    throw limit_error(path.string(),
                      fmt::format("{} x {} pixels in a frame of {} x {}", spec.width, spec.height,
                                  spec.full_width, spec.full_height),
                      fmt::format("the limit is {0} x {0}", limit));
  }
  if (spec.nchannels < 1 || spec.nchannels > max_channels) {
    throw limit_error(path.string(), fmt::format("{} channels", spec.nchannels),
                      fmt::format("the limit is {}", max_channels));
  }
}

float value_of_sample(const OIIO::DeepData& data, int64_t pixel, int channel, int sample) {
  if (data.channeltype(channel) == OIIO::TypeDesc::UINT32) {
    return static_cast<float>(data.deep_value_uint(pixel, channel, sample));
  }
  return data.deep_value(pixel, channel, sample);
}

}  // namespace

struct ExrRows::File {
  std::filesystem::path path;
  std::unique_ptr<OIIO::ImageInput> input;
  OIIO::ImageSpec spec;
  std::vector<int> chosen;        ///< channels
  std::vector<float> band;        ///< of the rows that were decoded last
  std::vector<std::byte> native;  ///< as they are stored

  /// Of the data's first pixel in the display window.
  int64_t left() const { return int64_t{spec.x} - spec.full_x; }
  int64_t top() const { return int64_t{spec.y} - spec.full_y; }

  void append_flat_row(const float* values, int first_channel, int channels,
                       std::vector<float>& out) const;
  int64_t read_flat_band(int64_t line, int64_t end, std::vector<float>& out);
  void read_deep_row(int64_t line, ExrRowValues& out);
  void check_row(const OIIO::DeepData& data, size_t values) const;
};

ExrRows::ExrRows(const std::filesystem::path& path) : file_(std::make_unique<File>()) {
  check_file(path);
  file_->path = path;
  file_->input = OIIO::ImageInput::create("openexr");
  if (!file_->input) throw unreadable(path, OIIO::geterror());
  if (!file_->input->open(path.string(), file_->spec)) {
    throw unreadable(path, file_->input->geterror());
  }
  check_spec(path, file_->spec);
}

ExrRows::~ExrRows() = default;
ExrRows::ExrRows(ExrRows&&) noexcept = default;
ExrRows& ExrRows::operator=(ExrRows&&) noexcept = default;

int ExrRows::width() const {
  return file_->spec.full_width;
}
int ExrRows::height() const {
  return file_->spec.full_height;
}
PixelRange ExrRows::data_window() const {
  const auto clamped = [](int64_t at, int size) {
    return static_cast<int>(std::clamp<int64_t>(at, 0, size));
  };
  const OIIO::ImageSpec& spec = file_->spec;
  return {{clamped(file_->left(), width()), clamped(file_->top(), height())},
          {clamped(file_->left() + spec.width, width()),
           clamped(file_->top() + spec.height, height())}};
}
bool ExrRows::is_deep() const {
  return file_->spec.deep;
}
std::vector<std::string> ExrRows::channels() const {
  return file_->spec.channelnames;
}
bool ExrRows::is_half(const std::string& channel) const {
  return file_->spec.channelformat(file_->spec.channelindex(channel)) == OIIO::TypeDesc::HALF;
}

void ExrRows::choose(std::span<const std::string> names) {
  file_->chosen.clear();
  for (const std::string& name : names) {
    file_->chosen.push_back(file_->spec.channelindex(name));
    if (file_->chosen.back() >= 0) continue;
    throw input_error(file_->path.string(),
                      fmt::format("there is no channel '{}'", printable(name)),
                      "check the channel's name");
  }
}

ExrRowValues ExrRows::read(int begin, int end) {
  const OIIO::ImageSpec& spec = file_->spec;
  CHECK(0 <= begin && begin <= end && end <= height());
  ExrRowValues rows;
  const size_t row_values = static_cast<size_t>(width()) * file_->chosen.size();
  // Reserving touches no memory: a file that ends early costs what it holds.
  if (!spec.deep) rows.values.reserve(row_values * static_cast<size_t>(end - begin));
  const int64_t last = std::min<int64_t>(end - file_->top(), spec.height);
  for (int64_t line = begin - file_->top(); line < end - file_->top();) {
    const bool is_inside = line >= 0 && line < spec.height;
    if (spec.deep && is_inside) {
      file_->read_deep_row(line++, rows);
    } else if (spec.deep) {
      rows.counts.resize(rows.counts.size() + width(), 0);
      ++line;
    } else if (is_inside) {
      line = file_->read_flat_band(line, last, rows.values);
    } else {
      rows.values.resize(rows.values.size() + row_values, 0.0f);
      ++line;
    }
  }
  return rows;
}

/// `values`: `channels` of each pixel of the data, from `first_channel` on.
void ExrRows::File::append_flat_row(const float* values, int first_channel, int channels,
                                    std::vector<float>& out) const {
  const size_t start = out.size();
  out.resize(start + static_cast<size_t>(spec.full_width) * chosen.size(), 0.0f);
  const int64_t first = std::max<int64_t>(0, -left());
  const int64_t end = std::min<int64_t>(spec.width, spec.full_width - left());
  for (int64_t x = first; x < end; ++x) {
    float* pixel = &out[start + static_cast<size_t>(x + left()) * chosen.size()];
    for (const int channel : chosen) *pixel++ = values[x * channels + channel - first_channel];
  }
}

/// Appends data lines from `line` on, before `end`; returns the line after them. Decodes the
/// channels between the first and the last chosen one, of tiled files whole rows of tiles.
int64_t ExrRows::File::read_flat_band(int64_t line, int64_t end, std::vector<float>& out) {
  const auto [low, high] = std::minmax_element(chosen.begin(), chosen.end());
  const int first_channel = chosen.empty() ? 0 : *low;
  const int channels = chosen.empty() ? 1 : *high + 1 - first_channel;
  const size_t row_values = static_cast<size_t>(spec.width) * channels;
  const int64_t most = std::max<int64_t>(1, static_cast<int64_t>(band_values / row_values));
  const bool is_tiled = spec.tile_width > 0;
  const int64_t step = is_tiled ? std::clamp(spec.tile_height, 1, max_flat_px) : 1;
  const int64_t first = line / step * step;
  const int64_t after =
      std::min<int64_t>(spec.height, (std::min(end, line + most) + step - 1) / step * step);
  band.resize(row_values * static_cast<size_t>(after - first));
  const int y = spec.y + static_cast<int>(first);
  const int y_end = spec.y + static_cast<int>(after);
  const OIIO::TypeDesc type = OIIO::TypeDesc::FLOAT;
  const bool ok =
      is_tiled ? input->read_tiles(0, 0, spec.x, spec.x + spec.width, y, y_end, spec.z, spec.z + 1,
                                   first_channel, first_channel + channels, type, band.data())
               : read_scanlines_as(*input, spec, y, y_end, first_channel, channels, type,
                                   band.data(), native);
  // Some readers only note that data ended early.
  if (!ok || input->has_error()) throw unreadable(path, input->geterror());
  const int64_t stop = std::min(end, after);
  for (int64_t i = line; i < stop; ++i) {
    append_flat_row(&band[row_values * static_cast<size_t>(i - first)], first_channel, channels,
                    out);
  }
  return stop;
}

void ExrRows::File::check_row(const OIIO::DeepData& data, size_t values) const {
  uint64_t samples = 0;
  for (int64_t pixel = 0; pixel < data.pixels(); ++pixel) {
    samples += static_cast<uint64_t>(std::max(0, data.samples(pixel)));
  }
  const uint64_t all_values = values + samples * chosen.size();
  if (samples <= max_row_samples && all_values <= max_value_bytes / sizeof(float)) return;
  throw limit_error(path.string(), "the samples of some rows take more than 8 GiB",
                    "write fewer samples a pixel");
}

void ExrRows::File::read_deep_row(int64_t line, ExrRowValues& out) {
  try {
    const int y = spec.y + static_cast<int>(line);
    OIIO::DeepData data;
    if (!input->read_native_deep_scanlines(0, 0, y, y + 1, 0, 0, spec.nchannels, data)) {
      throw unreadable(path, input->geterror());
    }
    check_row(data, out.values.size());
    for (int64_t x = 0; x < spec.full_width; ++x) {
      const int64_t pixel = x - left();
      const bool is_inside = pixel >= 0 && pixel < spec.width;
      const int count = is_inside ? data.samples(pixel) : 0;
      out.counts.push_back(static_cast<uint32_t>(count));
      for (int sample = 0; sample < count; ++sample) {
        for (const int channel : chosen) {
          out.values.push_back(value_of_sample(data, pixel, channel, sample));
        }
      }
    }
  } catch (const std::bad_alloc&) {
    throw limit_error(path.string(), "a row holds more samples than fit into memory",
                      "check that the file is complete");
  } catch (const std::length_error&) {
    throw unreadable(path, "a row says that it holds more samples than there can be");
  }
}

}  // namespace relume
