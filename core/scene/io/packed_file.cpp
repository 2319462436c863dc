#include "core/scene/io/packed_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <vector>

#include "core/base/error.h"

namespace relume {
namespace {

constexpr size_t step_bytes = size_t{1} << 16;
constexpr int gzip_window = 15 + 16;  // the largest window, with a gzip header

bool is_packed_name(const std::filesystem::path& path) {
  return path.extension() == ".gz";
}

/// zlib's state, given back at the end.
class Inflater {
 public:
  explicit Inflater(const std::string& file) : file_(file) {
    if (inflateInit2(&stream_, gzip_window) != Z_OK) throw std::bad_alloc();
  }
  ~Inflater() { inflateEnd(&stream_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  std::string unpack(std::span<const std::byte> packed) {
    const uint64_t limit = std::max(least_unpacked_limit, most_unpacked_times * packed.size());
    std::string text;
    std::vector<char> step(step_bytes);
    size_t taken = 0;
    while (true) {
      if (stream_.avail_in == 0) take(packed, taken);
      stream_.next_out = reinterpret_cast<Bytef*>(step.data());
      stream_.avail_out = step_bytes;
      const int state = inflate(&stream_, Z_NO_FLUSH);
      text.append(step.data(), step_bytes - stream_.avail_out);
      if (text.size() > limit) {
        throw limit_error(file_, fmt::format("unpacks to more than {} bytes", limit), "unpack it");
      }
      const bool is_at_end = taken == packed.size() && stream_.avail_in == 0;
      if (state == Z_STREAM_END) {
        if (is_at_end) return text;
        inflateReset(&stream_);  // another member follows
        continue;
      }
      if (state != Z_OK || (is_at_end && stream_.avail_out > 0)) {
        throw input_error(file_, "is no whole gzip file", "pack it again");
      }
    }
  }

 private:
  void take(std::span<const std::byte> packed, size_t& taken) {
    const size_t size = std::min(packed.size() - taken, step_bytes);
    // zlib reads only; its interface is older than const.
    stream_.next_in =
        const_cast<Bytef*>(reinterpret_cast<const Bytef*>(packed.data() + taken));  // NOLINT
    stream_.avail_in = static_cast<uInt>(size);
    taken += size;
  }

  const std::string& file_;
  z_stream stream_{};
};

}  // namespace

PackedFile::PackedFile(const std::filesystem::path& path)
    : file_(path), is_packed_(is_packed_name(path)) {
  if (!is_packed_) return;
  const std::string name = path.string();
  unpacked_ = Inflater(name).unpack(file_.bytes());
  file_ = MappedFile();
}

std::string_view PackedFile::text() const {
  if (is_packed_) return unpacked_;
  return {reinterpret_cast<const char*>(file_.bytes().data()), file_.bytes().size()};
}

std::filesystem::path unpacked_name(const std::filesystem::path& path) {
  return is_packed_name(path) ? path.parent_path() / path.stem() : path;
}

}  // namespace relume
