#include <fmt/format.h>

#include <algorithm>

#include "core/image/heatmap.h"
#include "core/image/image_io.h"
#include "core/image/metrics.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/json_output.h"

namespace relume {
namespace {

/// The reference's coverage channel, where the file has one.
std::vector<float> read_coverage(const std::filesystem::path& path) {
  const std::vector<std::string> names = read_channel_names(path);
  if (std::find(names.begin(), names.end(), "A") == names.end()) return {};
  return read_exr_channel(path, "A").pixels;
}

}  // namespace

int run_compare(const CompareOptions& options, const CommonOptions& common) {
  const Image image = read_image(options.image);
  const Image reference = read_image(options.reference);
  const ImageError error = compare_images(image, reference, read_coverage(options.reference));
  if (options.heatmap) {
    write_png(*options.heatmap, render_heatmap(error_image(image, reference),
                                               {.range = static_cast<float>(options.range)}));
  }
  const bool above = options.fail && error.error_image > *options.fail;
  print_figures("relume-compare-1", common,
                {{{"error_image", error.error_image},
                  {"error", error.error_covered},
                  {"rmse", error.rmse},
                  {"relative_mse", error.relative_mse},
                  {"max_error", error.max_error},
                  {"reference_mean", error.reference_mean},
                  {"covered_pixels", static_cast<int64_t>(error.covered_pixels)},
                  {"pixels", static_cast<int64_t>(error.pixels)}}});
  if (above) {
    fmt::print(stderr, "error_image {:.6g} is above {:.6g}\n", error.error_image, *options.fail);
  }
  return above ? 1 : 0;
}

}  // namespace relume
