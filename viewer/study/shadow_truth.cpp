#include "viewer/study/shadow_truth.h"

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/shade/reference.h"
#include "shadow/traced.h"
#include "viewer/study/lit_visibility.h"

namespace relume {
namespace {

/// Tiles between two reports of progress.
constexpr size_t batch_tiles = 16;

/// The samples of one type as receivers, in arrays of their own.
class TypeReceivers {
 public:
  TypeReceivers(const SampleType& type, const TypedRows& rows) : type_(type), rows_(rows) {
    const auto width = static_cast<size_t>(type.width);
    const auto add_column = [&](int offset) {
      std::vector<float>& column = columns_.emplace_back(rows.rows());
      for (size_t row = 0; row < rows.rows(); ++row)
        column[row] = rows.values[row * width + offset];
    };
    for (int axis = 0; axis < 3; ++axis) add_column(type.offsets[position_field] + axis);
    add_column(type.offsets[bias_field]);
    for (size_t i = 0; i < type.field_count(); ++i) {
      if (type.field(i).source != FieldSource::normal) continue;
      for (int axis = 0; axis < 3; ++axis) add_column(type.offsets[i] + axis);
      break;
    }
  }

  Receivers view() const {
    Receivers receivers;
    receivers.count = static_cast<int>(rows_.rows());
    receivers.weight = rows_.weights.data();
    for (int axis = 0; axis < 3; ++axis) {
      receivers.position[axis] = columns_[axis].data();
      if (columns_.size() == 7) receivers.normal[axis] = columns_[4 + axis].data();
    }
    receivers.bias = columns_[3].data();
    receivers.lit_from_behind = type_.shader->two_sided_transmission;
    return receivers;
  }

 private:
  const SampleType& type_;
  const TypedRows& rows_;
  std::vector<std::vector<float>> columns_;
};

/// Where a tile's pixels go within the window.
struct TilePlace {
  const SampleTile& tile;
  const StudyWindow& window;

  size_t index(int pixel) const {
    const int x = tile.x0 - window.x0 + pixel % tile.width;
    const int y = tile.y0 - window.y0 + pixel / tile.width;
    return static_cast<size_t>(y) * window.width + x;
  }
};

/// Sums over a tile's samples under one place of a light; `frame` may be null.
void trace_tile(const ViewSampler& view, const TilePlace& place,
                std::span<const TypeReceivers> receivers, const Light& light,
                std::vector<float>& visibility, Image* frame) {
  const SampleTile& tile = place.tile;
  TracedVisibility traced(*view.tracer);
  traced.prepare(light);
  const double scene_radius = view.tracer->bounds().radius();
  const dvec3 eye(view.rays.eye());
  std::vector<dvec3> color(tile.pixel_count(), dvec3(0));
  std::vector<dvec2> seen(tile.pixel_count(), dvec2(0));
  for (size_t t = 0; t < tile.types.size(); ++t) {
    const TypedRows& rows = tile.types[t];
    const SampleType& type = view.types.types[t];
    std::vector<float> answers(rows.rows());
    LitVisibility(traced, light).visibility(receivers[t].view(), answers.data());
    for (int pixel = 0; pixel < tile.pixel_count(); ++pixel) {
      for (uint32_t row = rows.first[pixel]; row < rows.first[pixel + 1]; ++row) {
        seen[pixel] += double{rows.weights[row]} * dvec2(answers[row], 1);
        if (frame == nullptr || answers[row] == 0) continue;
        const float* vector = &rows.values[size_t{row} * type.width];
        color[pixel] += double{rows.weights[row]} * answers[row] *
                        reference_response(type, vector, light, eye, scene_radius);
      }
    }
  }
  for (int pixel = 0; pixel < tile.pixel_count(); ++pixel) {
    const size_t i = place.index(pixel);
    visibility[i] = seen[pixel].y > 0 ? static_cast<float>(seen[pixel].x / seen[pixel].y) : 0.0f;
    if (frame == nullptr) continue;
    const dvec3 rgb = color[pixel] * dvec3(light.weight());
    for (int c = 0; c < 3; ++c) frame->pixels[3 * i + c] = static_cast<float>(rgb[c]);
  }
}

void add_tile(const ViewSampler& view, const StudyWindow& window,
              std::span<const StudyLight> lights, int index, ShadowTruth& truth) {
  const SampleTile tile = sample_tile(view, index);
  const TilePlace place{tile, window};
  std::vector<TypeReceivers> receivers;
  for (size_t t = 0; t < tile.types.size(); ++t) {
    receivers.emplace_back(view.types.types[t], tile.types[t]);
    const TypedRows& rows = tile.types[t];
    for (int pixel = 0; pixel < tile.pixel_count(); ++pixel) {
      if (rows.first[pixel + 1] > rows.first[pixel]) truth.covered[place.index(pixel)] = 1;
    }
  }
  for (size_t l = 0; l < lights.size(); ++l) {
    for (size_t step = 0; step < lights[l].path.size(); ++step) {
      trace_tile(view, place, receivers, lights[l].path[step], truth.steps[l][step],
                 step == 0 ? &truth.frames[l] : nullptr);
    }
  }
}

/// Calls visit(value) for every number of a tile, always in the same order.
template <class Visit>
void visit_tile(const TileRectangle& tile, const StudyWindow& window, ShadowTruth& truth,
                const Visit& visit) {
  for (int y = tile.y0; y < tile.y0 + tile.height; ++y) {
    for (int x = tile.x0; x < tile.x0 + tile.width; ++x) {
      const size_t i = static_cast<size_t>(y - window.y0) * window.width + (x - window.x0);
      visit(truth.covered[i]);
      for (auto& steps : truth.steps) {
        for (std::vector<float>& step : steps) visit(step[i]);
      }
      for (Image& frame : truth.frames) {
        for (size_t c = 0; c < 3; ++c) visit(frame.pixels[3 * i + c]);
      }
    }
  }
}

/// Takes the tiles from the log; false where it does not hold them.
bool read_tiles(const ViewSampler& view, const StudyWindow& window, std::span<const int> tiles,
                const std::vector<double>* values, ShadowTruth& truth) {
  if (values == nullptr) return false;
  size_t at = 0;
  for (const int tile : tiles) {
    visit_tile(tile_rectangle(view, tile), window, truth, [&](float& value) {
      CHECK(at < values->size());
      value = static_cast<float>((*values)[at++]);
    });
  }
  return true;
}

std::vector<double> list_tiles(const ViewSampler& view, const StudyWindow& window,
                               std::span<const int> tiles, ShadowTruth& truth) {
  std::vector<double> values;
  for (const int tile : tiles) {
    visit_tile(tile_rectangle(view, tile), window, truth,
               [&](float value) { values.push_back(value); });
  }
  return values;
}

}  // namespace

StudyWindow make_window(int size_px, vec2 center, int width, int height) {
  if (size_px <= 0) return {0, 0, width, height};
  const auto side = [size_px](float middle, int limit, int& first, int& count) {
    const int wanted = (std::min(size_px, limit) + tile_size - 1) / tile_size * tile_size;
    const int low = static_cast<int>(std::lround(middle)) - wanted / 2;
    const int last = std::max(0, (limit - wanted) / tile_size * tile_size);
    first = std::clamp((low + tile_size / 2) / tile_size * tile_size, 0, last);
    count = std::min(wanted, limit - first);
  };
  StudyWindow window;
  side(center.x, width, window.x0, window.width);
  side(center.y, height, window.y0, window.height);
  return window;
}

ShadowTruth trace_truth(const ViewSampler& view, const StudyWindow& window,
                        std::span<const StudyLight> lights, TrialLog& log,
                        const ProgressCallback& callback) {
  const size_t pixels = static_cast<size_t>(window.width) * window.height;
  ShadowTruth truth;
  truth.covered.assign(pixels, 0.0f);
  for (const StudyLight& light : lights) {
    truth.steps.emplace_back(light.path.size(), std::vector<float>(pixels, 0.0f));
    truth.frames.emplace_back(window.width, window.height);
  }
  std::vector<int> tiles;
  for (int i = 0; i < tile_count(view); ++i) {
    if (window.contains(tile_rectangle(view, i))) tiles.push_back(i);
  }
  Progress progress(callback, "trace the truth of " + view.scene->name);
  for (size_t first = 0; first < tiles.size(); first += batch_tiles) {
    const auto batch = std::span(tiles).subspan(first, std::min(batch_tiles, tiles.size() - first));
    const std::string key = fmt::format("{}: truth, tiles from {}", view.scene->name, first);
    if (read_tiles(view, window, batch, log.find(key), truth)) continue;
    parallel_for(batch.size(), 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) add_tile(view, window, lights, batch[i], truth);
    });
    log.add(key, list_tiles(view, window, batch, truth));
    progress.update(static_cast<double>(first + batch.size()), static_cast<double>(tiles.size()));
  }
  return truth;
}

}  // namespace relume
