#pragma once

#include <functional>
#include <memory>

#include "core/samples/relight_cache.h"
#include "core/trace/tracer.h"
#include "viewer/commands/options.h"
#include "viewer/session/prepare.h"

namespace relume {

/// What relighting starts from. `scene` and `tracer` are null for a cache opened without shadows.
struct RelightInput {
  std::unique_ptr<const Scene> scene;
  std::unique_ptr<const Tracer> tracer;
  std::optional<RelightCache> cache;
};

/// Who is told how far opening is.
struct OpenHooks {
  ProgressCallback progress;  ///< empty: the terminal
  /// See PrepareParams; empty: nobody.
  std::function<void(const ViewSampler& view, const SampleTile& records)> on_tile;
};

/// Loads a scene and builds its ray tracer.
RelightInput open_scene(const std::string& name_or_path, const CommonOptions& common,
                        const OpenHooks& hooks = {});

/// The same without emission, told in one line: what a material emits is the same for every method,
/// light and shadow, and would only make errors look small beside it.
RelightInput open_study_scene(const std::string& name_or_path, const CommonOptions& common);

/// A scene (label or path), prepared in memory as `prepare` says, or a .relume cache. A cache's
/// scene is loaded only when `need_tracer`, from the text stored in the cache; generated and
/// unchanged files give the geometry that the cache was made from.
RelightInput open_input(const std::string& input, const PrepareOptions& prepare, bool need_tracer,
                        const CommonOptions& common, const OpenHooks& hooks = {});

/// `options` with what `shadow` needs of a cache, where nothing else was asked for.
PrepareOptions prepare_for(ShadowMethod shadow, PrepareOptions options);

/// `options` but for every sample as a record of its own.
PrepareOptions all_samples(PrepareOptions options);

/// The same choices as the library's parameters.
PrepareParams make_prepare_params(const PrepareOptions& options, const CommonOptions& common);

/// True for a path that ends in .relume.
bool is_cache_path(const std::string& path);

/// How `options` show frames of a cache as PNG.
inline DisplayTransform display_of(const RenderOptions& options, const CacheInfo& info) {
  return {.exposure = options.exposure.value_or(info.exposure),
          .curve = options.curve.value_or(default_curve())};
}

}  // namespace relume
