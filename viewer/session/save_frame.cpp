#include "viewer/session/save_frame.h"

#include <fmt/format.h>

#include <optional>
#include <set>

#include "core/base/error.h"
#include "core/image/heatmap.h"
#include "core/image/image_io.h"
#include "viewer/commands/version.h"
#include "viewer/session/view_state.h"

namespace relume {
namespace {

/// Light names as channel prefixes: characters that separate layers become '_', repeats get a
/// number.
std::vector<std::string> layer_prefixes(const std::vector<Light>& lights) {
  std::vector<std::string> prefixes;
  std::set<std::string> used;
  for (const Light& light : lights) {
    std::string name = light.name.empty() ? "light" : light.name;
    for (char& c : name) {
      const auto u = static_cast<unsigned char>(c);
      if (u <= ' ' || u >= 0x7f || c == '.' || c == '/' || c == ',') c = '_';
    }
    std::string unique = name;
    for (int i = 2; !used.insert(unique).second; ++i) unique = fmt::format("{}_{}", name, i);
    prefixes.push_back("light." + unique + ".");
  }
  return prefixes;
}

void save_exr(const RelightState& state, const std::filesystem::path& path) {
  const CacheInfo& info = state.cache->info();
  const Image coverage = make_map(info.width, info.height, state.cache->coverage());
  const Image records = make_map(info.width, info.height, state.cache->record_counts());
  std::vector<Image> lights;
  for (size_t i = 0; i < state.lights.size(); ++i) lights.push_back(weighted_layer(state, i));
  const std::vector<std::string> prefixes = layer_prefixes(state.lights);
  std::vector<ExrLayer> layers = {{"", {"R", "G", "B"}, &state.frame}, {"", {"A"}, &coverage}};
  for (size_t i = 0; i < lights.size(); ++i) {
    layers.push_back({prefixes[i], {"R", "G", "B"}, &lights[i]});
  }
  layers.push_back({"records.", {"V"}, &records});
  std::optional<Image> predicted;
  if (info.has_predicted_error) {
    predicted = make_map(info.width, info.height, state.cache->predicted_error());
    layers.push_back({"predicted_error.", {"V"}, &*predicted});
  }
  write_exr(path, layers,
            {{"relume:version", relume_version},
             {"relume:commit", relume_commit},
             {"relume:scene", info.scene_name},
             {"relume:method", info.method},
             {"relume:records", fmt::format("{}", info.records)},
             {"relume:average_records", fmt::format("{}", info.average_records)},
             {"relume:target_error", fmt::format("{}", info.target_error)},
             {"relume:spp", fmt::format("{}", info.spp)},
             {"relume:seed", fmt::format("{}", info.seed)}});
}

}  // namespace

void save_frame(const RelightState& state, const DisplayTransform& display,
                const std::filesystem::path& path) {
  if (path.extension() == ".exr") {
    save_exr(state, path);
  } else if (path.extension() == ".png") {
    write_png(path, apply_display(state.frame, display));
  } else {
    throw Error(ErrorKind::usage, path.string() + ": unknown picture format; use .exr or .png");
  }
}

void save_predicted_error(const RelightCache& cache, const std::filesystem::path& path) {
  const CacheInfo& info = cache.info();
  if (!info.has_predicted_error) {
    throw Error(ErrorKind::usage,
                fmt::format("--predicted-error: method {} predicted no errors", info.method));
  }
  write_png(path, render_heatmap(make_map(info.width, info.height, cache.predicted_error()), {}));
}

void save_record_map(const RelightCache& cache, const std::filesystem::path& path) {
  const CacheInfo& info = cache.info();
  write_png(path, render_heatmap(make_map(info.width, info.height, cache.record_counts()),
                                 {.range = record_map_range(info.records)}));
}

}  // namespace relume
