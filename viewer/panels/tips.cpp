#include "viewer/panels/tips.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <utility>

namespace relume {
namespace {

using Tip = std::pair<std::string_view, std::string_view>;

constexpr std::array tips = {
    Tip{"view.frame", "The relit records"},
    Tip{"view.reference", "Every sample, with traced shadows"},
    Tip{"view.heatmap", "How far the frame is from the reference"},
    Tip{"view.predicted", "The error that preparation expects of each pixel"},
    Tip{"view.records", "How many records each pixel has"},
    Tip{"view.difference", "Ten times the frame minus the reference, around grey"},
    Tip{"view.visibility", "How much of each pixel the selected light reaches"},
    Tip{"view.type", "The material type that most of a pixel belongs to"},
    Tip{"view.normal", "Normals; tangents on strands"},
    Tip{"view.exposure", "Of the display alone; ctrl and a click to type"},
    Tip{"view.curve.srgb", "Straight to sRGB, bright parts clip"},
    Tip{"view.curve.filmic", "Bright parts roll off"},
    Tip{"view.curve.config", "The view of the OpenColorIO configuration in $OCIO"},
    Tip{"view.false_color", "Luminance in stops from middle grey"},
    Tip{"heatmap.#x", "Maps of error end at 0.1: errors ten times enlarged"},
    Tip{"heatmap.auto", "Maps of error end where the picture's errors do"},
    Tip{"shadows.none", "Every light reaches everything"},
    Tip{"shadows.ray", "One traced ray a record"},
    Tip{"shadows.members", "Traced rays from every sample of a record; needs --members"},
    Tip{"shadows.coverage", "The part of each record that hair and leaves hide, without noise"},
    Tip{"shadows.opacity", "Maps of what each light sees first; quick, soft"},
    Tip{"shadows.volume", "Cells swept from the light; quickest, softest"},
    Tip{"shadows.auto", "Quick while a light is dragged, finer when it rests"},
    Tip{"trade.manual", "Records stay; the settings below are yours"},
    Tip{"trade.level", "One slider from the fastest frames to exact ones"},
    Tip{"trade.time", "As exact as a time for each light move allows"},
    Tip{"trade.error", "As quick as an error of shading allows"},
    Tip{"trade.value", "Other records are prepared in the background"},
    Tip{"trade.plan",
        "Predicted, without shadows: records a pixel on average, their format, the time to shade "
        "one moved light, the error as a part of the picture's mean"},
    Tip{"view.frame_ms", "Slower frames come with a quarter of the pixels first"},
    Tip{"view.refine", "The exact picture follows when nothing moves"},
    Tip{"snapshot.take", "Keep this picture to compare with"},
    Tip{"snapshot.flip", "Show the snapshot in place of the picture"},
    Tip{"snapshot.wipe", "Snapshot left of a line, picture right of it"},
    Tip{"snapshot.restore", "Take the lights of the snapshot"},
    Tip{"lights.add", "A point light before the scene"},
    Tip{"lights.#.solo", "Solo: the other lights are dark"},
    Tip{"lights.#.mute", "Mute: this light is dark"},
    Tip{"light.gain", "Drag, or ctrl and a click to type"},
    Tip{"light.kelvin", "A black body's colour in the present luminance"},
    Tip{"light.falloff", "Inverse square"},
    Tip{"light.range", "Beyond it the light is nothing; 0: it ends nowhere"},
    Tip{"light.inner", "Half the angle of full brightness"},
    Tip{"light.outer", "Half the angle beyond which it is dark"},
};

/// "lights.12.solo" as "lights.#.solo".
std::string without_numbers(std::string_view item) {
  std::string name;
  for (const char c : item) {
    const bool is_digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
    if (!is_digit) {
      name += c;
    } else if (name.empty() || name.back() != '#') {
      name += '#';
    }
  }
  return name;
}

}  // namespace

std::string_view tip_of(std::string_view item) {
  const std::string name = without_numbers(item);
  const auto found =
      std::find_if(tips.begin(), tips.end(), [&](const Tip& tip) { return tip.first == name; });
  return found != tips.end() ? found->second : std::string_view();
}

}  // namespace relume
