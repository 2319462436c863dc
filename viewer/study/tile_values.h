#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/samples/sample_scene.h"
#include "reduction/training.h"
#include "shadow/traced.h"

namespace relume {

/// Lights that a study looks at tiles under, with a shadow ray to each. Const use is thread-safe.
struct TestLights {
  TrainingSet set;                                         ///< without visibility
  std::vector<std::unique_ptr<TracedVisibility>> shadows;  ///< per column; null: casts no shadow
  std::vector<size_t> columns;                             ///< of the lights in their order

  size_t count() const { return columns.size(); }
  /// Per column, what shadows it by a ray.
  std::vector<const VisibilitySource*> sources() const;
};

/// `scene_radius` in world units; keeps references to `view`'s types and tracer. Lights of one kind
/// keep their order; `columns` follow the order in which kinds come.
TestLights make_test_lights(std::span<const Light> lights, const ViewSampler& view,
                            float scene_radius);

/// What a tile's pixels look like under each light alone.
struct TileValues {
  std::vector<float> plain;   ///< (pixel * 3 + c) * lights + light: unshadowed
  std::vector<float> traced;  ///< the same, each row with one shadow ray a light; empty = not asked
};

/// Rows are samples or records. `shadows`: what shadows each column, null: nothing; an empty span:
/// TileValues::traced is not asked for.
TileValues tile_values(const SampleTile& tile, std::span<const SampleType> types,
                       const TestLights& lights, std::span<const VisibilitySource* const> shadows);

}  // namespace relume
