#include "viewer/aovs/aov_strips.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/samples/sample_tile.h"

namespace relume {
namespace {

constexpr uint32_t max_deep_samples = 1024;  // of a pixel
constexpr double most_weight = 1.001;        // half floats

}  // namespace

uint64_t AovStrip::bytes() const {
  return values.capacity() * sizeof(float) + first.capacity() * sizeof(uint64_t) +
         weights.capacity() * sizeof(float);
}

AovStrips::AovStrips(std::filesystem::path path, ExrRows file, int side, size_t channels,
                     Weighing weighing, uint64_t kept_bytes)
    : path_(std::move(path)),
      file_(std::move(file)),
      side_(side),
      channels_(channels),
      weighing_(weighing),
      kept_bytes_(kept_bytes) {}

std::shared_ptr<const AovStrip> AovStrips::strip(int index) {
  const std::scoped_lock lock(mutex_);
  const auto found = std::find_if(kept_.begin(), kept_.end(),
                                  [&](const Kept& kept) { return kept.index == index; });
  if (found != kept_.end()) {
    kept_.splice(kept_.begin(), kept_, found);
    return found->strip;
  }
  // Room for the strip is made before it is read.
  uint64_t bytes = largest_bytes_;
  for (const Kept& kept : kept_) bytes += kept.strip->bytes();
  while (!kept_.empty() && bytes > kept_bytes_) {
    bytes -= kept_.back().strip->bytes();
    kept_.pop_back();
  }
  kept_.push_front({index, read(index)});
  largest_bytes_ = std::max(largest_bytes_, kept_.front().strip->bytes());
  return kept_.front().strip;
}

std::shared_ptr<const AovStrip> AovStrips::read(int index) {
  auto strip = std::make_shared<AovStrip>();
  const int height = file_.height() / side_;
  strip->y0 = index * tile_size;
  strip->height = std::min(tile_size, height - strip->y0);
  ExrRowValues rows = file_.read(strip->y0 * side_, (strip->y0 + strip->height) * side_);
  strip->values = std::move(rows.values);
  if (weighing_ != Weighing::even) set_weights(*strip, rows.counts);
  return strip;
}

/// Weights as they stand, or, of alphas, what each sample adds to a picture behind those before it.
void AovStrips::set_weights(AovStrip& strip, std::span<const uint32_t> counts) {
  strip.values.shrink_to_fit();
  strip.first.assign(1, 0);
  for (size_t pixel = 0; pixel < counts.size(); ++pixel) {
    if (counts[pixel] > max_deep_samples) {
      throw limit_error(path_.string(), fmt::format("a pixel holds {} samples", counts[pixel]),
                        fmt::format("the limit is {}", max_deep_samples));
    }
    most_samples_ = std::max<uint32_t>(most_samples_, counts[pixel]);
    strip.first.push_back(strip.first.back() + counts[pixel]);
    double sum = 0;
    double transmittance = 1;
    for (uint64_t i = strip.first[pixel]; i < strip.first[pixel + 1]; ++i) {
      const float value = strip.values[(i + 1) * channels_ - 1];
      const double weight = weighing_ == Weighing::alpha ? value * transmittance : double{value};
      transmittance *= 1 - double{value};
      sum += weight;
      if (!(value >= 0) || !(sum <= most_weight)) {
        const size_t width = static_cast<size_t>(file_.width());
        throw input_error(path_.string(),
                          fmt::format("the weights of pixel ({}, {}) are not within [0, 1]",
                                      pixel % width, strip.y0 + pixel / width),
                          "give a channel 'weight', or 'A' of samples sorted by depth");
      }
      strip.weights.push_back(static_cast<float>(weight));
    }
  }
}

}  // namespace relume
