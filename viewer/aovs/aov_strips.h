#pragma once

#include <atomic>
#include <list>
#include <mutex>

#include "core/image/exr_rows.h"

namespace relume {

/// What an AOV image holds of one row of tiles.
struct AovStrip {
  int y0 = 0;                 ///< pixels
  int height = 0;             ///< pixels
  std::vector<float> values;  ///< of each sub-pixel or deep sample, row by row
  /// Deep: pixel p of the strip owns samples [first[p], first[p + 1]), whose weights are in
  /// `weights`. Else empty.
  std::vector<uint64_t> first;
  std::vector<float> weights;

  uint64_t bytes() const;
};

/// The strips of an AOV image: read when they are asked for, those used last kept. Thread-safe; one
/// thread reads at a time.
class AovStrips {
 public:
  /// What deep samples weigh.
  enum class Weighing { even, weight, alpha };

  /// `file` gives the channels of the samples; the last one is the weight or alpha, where
  /// `weighing` is one. `side`: sub-pixels of a pixel's side, 1 for deep images. Strips together
  /// take at most `kept_bytes` beside those that are in use.
  AovStrips(std::filesystem::path path, ExrRows file, int side, size_t channels, Weighing weighing,
            uint64_t kept_bytes);

  /// The most samples of a pixel in the strips that were read so far; 0 of flat images.
  uint32_t most_samples() const { return most_samples_; }
  /// Strip `index`. Throws as ExrRows::read does, and for deep images Error(input) where a pixel's
  /// weights do not lie in [0, 1], Error(limit) where it has more than 1024 samples.
  std::shared_ptr<const AovStrip> strip(int index);

 private:
  struct Kept {
    int index;
    std::shared_ptr<const AovStrip> strip;
  };

  std::shared_ptr<const AovStrip> read(int index);
  void set_weights(AovStrip& strip, std::span<const uint32_t> counts);

  std::filesystem::path path_;
  ExrRows file_;
  int side_;
  size_t channels_;
  Weighing weighing_;
  uint64_t kept_bytes_;
  std::mutex mutex_;      ///< over all that follows and the reading of file_
  std::list<Kept> kept_;  ///< used last first
  uint64_t largest_bytes_ = 0;
  std::atomic<uint32_t> most_samples_{0};
};

}  // namespace relume
