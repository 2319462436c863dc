#include "viewer/aovs/aov_writer.h"

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/image/image_io.h"
#include "core/scene/limits.h"
#include "viewer/aovs/channel_names.h"

namespace relume {
namespace {

/// The images of the view's fields.
class AovImages {
 public:
  AovImages(const ViewSampler& view, int side)
      : view_(view), side_(side), id_(view.width * side, view.height * side, 1) {
    for (const SampleType& type : view.types.types) {
      std::vector<size_t>& fields = layer_of_field_.emplace_back();
      for (size_t i = 0; i < type.field_count(); ++i) fields.push_back(find_layer(type.field(i)));
    }
  }

  void add_tile(int index) {
    SampleCells cells;
    const SampleTile tile = sample_tile(view_, index, cells);
    for (size_t t = 0; t < tile.types.size(); ++t) {
      for (int pixel = 0; pixel < tile.pixel_count(); ++pixel) {
        const uint32_t end = tile.types[t].first[pixel + 1];
        for (uint32_t row = tile.types[t].first[pixel]; row < end; ++row) {
          const int cell = cells[t][row];
          add_sample(t, tile.types[t], row, (tile.x0 + pixel % tile.width) * side_ + cell % side_,
                     (tile.y0 + pixel / tile.width) * side_ + cell / side_);
        }
      }
    }
  }

  void write(const std::filesystem::path& path) const {
    std::vector<ExrLayer> layers = {{"id.", {"V"}, &id_}};
    for (const Layer& layer : layers_) {
      layers.push_back({layer.prefix, layer.components, &layer.image});
    }
    write_exr(path, layers, {{"relume:samples_per_side", fmt::format("{}", side_)}});
  }

 private:
  struct Layer {
    std::string prefix;
    std::vector<std::string> components;
    Image image;
  };

  size_t find_layer(const SampleField& field) {
    const std::string prefix = layer_of(field);
    for (size_t i = 0; i < layers_.size(); ++i) {
      if (layers_[i].prefix == prefix) return i;
    }
    layers_.push_back({prefix, components_of(field), Image(id_.width, id_.height, field.width)});
    return layers_.size() - 1;
  }

  void add_sample(size_t t, const TypedRows& rows, uint32_t row, int x, int y) {
    const SampleType& type = view_.types.types[t];
    const float* values = &rows.values[static_cast<size_t>(row) * type.width];
    for (size_t i = 0; i < type.field_count(); ++i) {
      std::copy_n(values + type.offsets[i], type.field(i).width,
                  layers_[layer_of_field_[t][i]].image.at(x, y));
    }
    *id_.at(x, y) = id_of_shader(type.shader);
  }

  const ViewSampler& view_;
  int side_;
  Image id_;
  std::vector<Layer> layers_;
  std::vector<std::vector<size_t>> layer_of_field_;  ///< per type, per field
};

}  // namespace

void write_aovs(const ViewSampler& view, int samples_per_side, const std::filesystem::path& path,
                const ProgressCallback& callback) {
  CHECK(view.strata.spp == samples_per_side * samples_per_side);
  if (std::max(view.width, view.height) > max_image_side / samples_per_side) {
    throw limit_error(path.string(),
                      fmt::format("{} x {} sub-pixels", view.width * samples_per_side,
                                  view.height * samples_per_side),
                      fmt::format("the limit is {0} x {0}", max_image_side));
  }
  AovImages images(view, samples_per_side);
  const auto tiles = static_cast<size_t>(tile_count(view));
  Progress progress(callback, "sample " + view.scene->name);
  constexpr size_t batch_tiles = 128;
  for (size_t first = 0; first < tiles; first += batch_tiles) {
    const size_t count = std::min(batch_tiles, tiles - first);
    parallel_for(count, 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) images.add_tile(static_cast<int>(first + i));
    });
    progress.update(static_cast<double>(first + count), static_cast<double>(tiles));
  }
  images.write(path);
}

}  // namespace relume
