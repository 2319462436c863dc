#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/base/label.h"
#include "core/image/display_transform.h"
#include "core/samples/record_layout.h"
#include "core/scene/light.h"
#include "shadow/shadow.h"

namespace relume {

/// What the picture shows. `reference` is every sample with traced shadows; `heatmap` is the error
/// of the frame against it, and `difference` ten times the frame minus the reference around grey.
/// `predicted` is the error that preparation expects of each pixel, `records` how many records it
/// has, `type` the sample type that most of it belongs to and `normal` its mean normal, all of them
/// whatever the lights. `visibility` is how much of it the selected light reaches.
enum class ShownPicture {
  frame,
  reference,
  heatmap,
  predicted,
  records,
  difference,
  visibility,
  type,
  normal
};

inline constexpr std::array shown_picture_labels = {
    Label<ShownPicture>{ShownPicture::frame, "frame"},
    Label<ShownPicture>{ShownPicture::reference, "reference"},
    Label<ShownPicture>{ShownPicture::heatmap, "heatmap"},
    Label<ShownPicture>{ShownPicture::predicted, "predicted"},
    Label<ShownPicture>{ShownPicture::records, "records"},
    Label<ShownPicture>{ShownPicture::difference, "difference"},
    Label<ShownPicture>{ShownPicture::visibility, "visibility"},
    Label<ShownPicture>{ShownPicture::type, "type"},
    Label<ShownPicture>{ShownPicture::normal, "normal"},
};

/// True for pictures that come from the reference.
constexpr bool needs_reference(ShownPicture shown) {
  return shown == ShownPicture::reference || shown == ShownPicture::heatmap ||
         shown == ShownPicture::difference;
}

/// True for pictures that lights do not change.
constexpr bool ignores_lights(ShownPicture shown) {
  return shown == ShownPicture::predicted || shown == ShownPicture::records ||
         shown == ShownPicture::type || shown == ShownPicture::normal;
}

/// Where the scale of the heatmap and of the predicted error ends: at an error of 0.1, so that
/// errors are shown ten times enlarged as in TR2007-600, or where the picture's own errors end
/// (automatic_range).
enum class HeatRange { ten_times, automatic };

inline constexpr std::array heat_range_labels = {
    Label<HeatRange>{HeatRange::ten_times, "10x"},
    Label<HeatRange>{HeatRange::automatic, "auto"},
};

/// Where the scale of a map of records per pixel ends, for k records asked for.
constexpr float record_map_range(int k) {
  return static_cast<float>(std::max(16, k));
}

/// Who says how quick or how exact frames shall be: the settings one by one, a level between the
/// fastest and exact, the time of a light move, or an error.
enum class TradeKind { manual, level, time, error };

inline constexpr std::array trade_kind_labels = {
    Label<TradeKind>{TradeKind::manual, "manual"},
    Label<TradeKind>{TradeKind::level, "level"},
    Label<TradeKind>{TradeKind::time, "time"},
    Label<TradeKind>{TradeKind::error, "error"},
};

/// Time against error. Each kind keeps its value while another one is in effect.
struct Trade {
  TradeKind kind = TradeKind::manual;
  float level = 0.5f;          ///< 0 = fastest to 1 = exact
  float move_ms = 20;          ///< milliseconds that moving one light may take
  float target_error = 0.02f;  ///< fraction of the picture's mean
  bool operator==(const Trade&) const = default;
};

/// Records that are prepared anew in place of those that were opened.
struct RecordChoice {
  float average = 0;  ///< per covered pixel; 0 = as opened
  CacheFormat format = CacheFormat::exact;
  bool is_set() const { return average > 0; }
  bool operator==(const RecordChoice&) const = default;
};

/// Everything that a person sets in the viewer, and nothing else: copying it is a snapshot.
struct ViewState {
  std::vector<Light> lights;
  int selected_light = -1;  ///< index into lights, or -1
  /// Ascending indices into lights; unless there are none, the other lights are dark.
  std::vector<int> solo_lights;
  ShownPicture shown = ShownPicture::frame;
  ShadowMethod shadows = ShadowMethod::ray;
  DisplayTransform display;
  bool false_color = false;  ///< pictures show their luminance in stops, see false_color.h
  HeatRange heat_range = HeatRange::ten_times;
  /// A frame that is predicted to take longer, in milliseconds, is first shown coarse: a quarter of
  /// the pixels. 0: never.
  float frame_ms = 40;
  /// When the lights rest, the frame gives way to all samples with traced shadows, if there is a
  /// reference and the frame has shadows.
  bool refine = false;
  Trade trade;
  RecordChoice records;    ///< follows from the trade
  float zoom = 0;          ///< screen pixels per picture pixel; 0 = fit into the window
  vec2 zoom_center_px{0};  ///< picture position in the middle of the window when zoom > 0
};

/// `image`, scene-linear, as `view` displays pictures: RGBA, 8 bits. Resizes `rgba`. Throws as
/// apply_display_rgba().
void display_image(const Image& image, const ViewState& view, DisplayQuality quality,
                   std::vector<uint8_t>& rgba);

/// The lights as the picture shows them: muted where others are soloed.
std::vector<Light> shown_lights(const ViewState& view);

/// True when the two are equal in everything, names included.
bool same_light(const Light& a, const Light& b);

/// True when both give the same frame: lights equal in all but their names.
bool same_lighting(std::span<const Light> a, std::span<const Light> b);

}  // namespace relume
