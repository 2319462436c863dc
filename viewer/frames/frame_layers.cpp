#include "viewer/frames/frame_layers.h"

#include <fmt/format.h>

#include <set>

#include "core/base/error.h"
#include "core/relight/emission.h"
#include "core/relight/pixel_means.h"
#include "core/relight/pixel_visibility.h"
#include "core/samples/geometry_hash.h"
#include "core/scene/io/load_scene.h"
#include "viewer/commands/version.h"

namespace relume {
namespace {

/// Light names as parts of channel names: characters that separate layers become '_', repeats get a
/// number.
std::vector<std::string> channel_names(const std::vector<Light>& lights) {
  std::vector<std::string> names;
  std::set<std::string> used;
  for (const Light& light : lights) {
    std::string name = light.name.empty() ? "light" : light.name;
    for (char& c : name) {
      const auto u = static_cast<unsigned char>(c);
      if (u <= ' ' || u >= 0x7f || c == '.' || c == '/' || c == ',') c = '_';
    }
    std::string unique = name;
    for (int i = 2; !used.insert(unique).second; ++i) unique = fmt::format("{}_{}", name, i);
    names.push_back(unique);
  }
  return names;
}

/// What the records of each pixel see of a light; 1 where nothing casts shadows.
std::vector<float> light_visibility(const RelightCache& cache, const Light& light,
                                    VisibilitySource* shadows) {
  if (shadows != nullptr && light.casts_shadow) {
    shadows->prepare(light);
    return pixel_visibility(cache, *shadows);
  }
  std::vector<float> seen = cache.record_counts();
  for (float& value : seen) value = value > 0 ? 1.0f : 0.0f;
  return seen;
}

class LayerMaker {
 public:
  LayerMaker(const RelightState& state, const FrameRecipe& recipe)
      : state_(state),
        cache_(*state.cache),
        recipe_(recipe),
        light_names_(channel_names(state.lights)) {}

  FrameLayers make() {
    result_.layers = {{"", {"R", "G", "B"}, &state_.frame}};
    add_map("", "A", cache_.coverage());
    for (size_t i = 0; i < state_.lights.size(); ++i) {
      add("light." + light_names_[i] + ".", {"R", "G", "B"}, weighted_layer(state_, i));
    }
    if (cache_.info().has_emission) add("emission.", {"R", "G", "B"}, emission_image(cache_));
    add_map("records.", "V", cache_.record_counts());
    if (cache_.info().has_predicted_error) {
      add_map("predicted_error.", "V", cache_.predicted_error());
    }
    for (const FrameAov aov : recipe_.aovs) add_aov(aov);
    return std::move(result_);
  }

 private:
  void add(const std::string& prefix, const std::vector<std::string>& names, Image image) {
    result_.images.push_back(std::move(image));
    result_.layers.push_back({prefix, names, &result_.images.back()});
  }

  void add_map(const std::string& prefix, const std::string& name, std::vector<float> values) {
    add(prefix, {name}, make_map(state_.frame.width, state_.frame.height, std::move(values)));
  }

  void add_aov(FrameAov aov) {
    const std::vector<std::string> xyz{"X", "Y", "Z"};
    switch (aov) {
      case FrameAov::position:
        return add("P.", xyz, pixel_means(cache_, MeanField::position));
      case FrameAov::normal:
        return add("N.", xyz, pixel_means(cache_, MeanField::normal));
      case FrameAov::albedo:
        return add("albedo.", {"R", "G", "B"}, pixel_means(cache_, MeanField::albedo));
      case FrameAov::coverage:
        return add_map("coverage.", "V", cache_.coverage());
      case FrameAov::visibility:
        for (size_t i = 0; i < state_.lights.size(); ++i) {
          add_map("visibility." + light_names_[i] + ".", "V",
                  light_visibility(cache_, state_.lights[i], recipe_.shadows));
        }
        return;
      case FrameAov::error:  // predicted_error.V is always there where the cache has it
        if (cache_.info().has_predicted_error) return;
        throw Error(ErrorKind::usage, fmt::format("--aov error: method {} predicted no errors; "
                                                  "prepare with --predict-error",
                                                  cache_.info().method));
    }
  }

  const RelightState& state_;
  const RelightCache& cache_;
  const FrameRecipe& recipe_;
  std::vector<std::string> light_names_;
  FrameLayers result_;
};

std::string aov_list(const std::vector<FrameAov>& aovs) {
  std::string text;
  for (const FrameAov aov : aovs) {
    if (!text.empty()) text += ',';
    text += label_of(frame_aov_labels, aov);
  }
  return text;
}

}  // namespace

std::string scene_input(const CacheInfo& info) {
  return info.scene_file.empty() ? info.scene_name : info.scene_file;
}

FrameLayers make_frame_layers(const RelightState& state, const FrameRecipe& recipe) {
  return LayerMaker(state, recipe).make();
}

FrameMetadata make_frame_metadata(const RelightCache& cache, const std::vector<Light>& lights,
                                  const FrameRecipe& recipe) {
  const CacheInfo& info = cache.info();
  const InstructionSet set = choose_instruction_set(recipe.instruction_set);
  FrameMetadata metadata = {
      {"relume:version", relume_version},
      {"relume:commit", relume_commit},
      {"relume:scene", info.scene_name},
      {"relume:scene_file", scene_input(info)},
      {"relume:cache_hash", fmt::format("{:016x}", cache.hash())},
      {"relume:method", info.method},
      {"relume:records", fmt::format("{}", info.records)},
      {"relume:average_records", fmt::format("{}", info.average_records)},
      {"relume:target_error", fmt::format("{}", info.target_error)},
      {"relume:members", info.has_members ? "1" : "0"},
      {"relume:format", std::string(label_of(cache_format_labels, info.format))},
      {"relume:spp", fmt::format("{}", info.spp)},
      {"relume:seed", fmt::format("{}", info.seed)},
      {"relume:shadow", std::string(label_of(shadow_method_labels, recipe.shadow))},
      {"relume:isa", std::string(label_of(instruction_set_labels, set))},
      {"relume:aovs", aov_list(recipe.aovs)},
      {"relume:lights", format_lights(lights)}};
  if (recipe.scene != nullptr && recipe.shadow != ShadowMethod::none) {
    metadata.emplace_back("relume:geometry_hash",
                          fmt::format("{:016x}", geometry_hash(*recipe.scene)));
  }
  return metadata;
}

}  // namespace relume
