#include "viewer/session/session_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/samples/footprint.h"
#include "core/scene/io/json_lights.h"
#include "core/scene/io/load_scene.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

constexpr size_t max_path_length = 4096;  // bytes
constexpr float max_frame_ms = 1e6f;
constexpr float least_trade_ms = 0.01f;
constexpr float least_trade_error = 1e-6f;
constexpr float max_stops = 20;
constexpr float max_zoom = 64;

template <class E, size_t N>
std::string quoted_label(const std::array<Label<E>, N>& labels, E value) {
  return json_quoted(std::string(label_of(labels, value)));
}

std::string format_prepare(const SessionFile& session) {
  const PrepareOptions& prepare = session.prepare;
  std::string out = fmt::format(R"({{"spp": {}, "method": {}, "preset": {})", prepare.spp,
                                quoted_label(reduction_method_labels, prepare.method),
                                quoted_label(reduction_preset_labels, prepare.preset));
  if (prepare.format) {
    out += ", \"format\": " + quoted_label(cache_format_labels, *prepare.format);
  }
  if (prepare.frame_ms > 0) out += ", \"frame_ms\": " + json_number(prepare.frame_ms);
  if (prepare.records) out += fmt::format(", \"records\": {}", *prepare.records);
  if (prepare.members) out += fmt::format(", \"members\": {}", *prepare.members);
  if (prepare.budget.average_records > 0) {
    out += ", \"average_records\": " + json_number(prepare.budget.average_records);
  }
  if (prepare.budget.target_error > 0) {
    out += ", \"target_error\": " + json_number(prepare.budget.target_error);
  }
  return out + fmt::format(
                   ", \"predict_error\": {}, \"training_lights\": {}, \"train_shadows\": {}, "
                   "\"width\": {}, \"height\": {}, \"seed\": {}}}",
                   prepare.predict_error, prepare.training_lights, prepare.train_shadows,
                   prepare.width, prepare.height, session.seed);
}

std::string format_trade(const ViewState& view) {
  const Trade& trade = view.trade;
  std::string out =
      fmt::format(R"("trade": {}, "trade_level": {}, "trade_ms": {}, "trade_error": {})",
                  quoted_label(trade_kind_labels, trade.kind), json_number(trade.level),
                  json_number(trade.move_ms), json_number(trade.target_error));
  if (!view.records.is_set()) return out;
  return out + fmt::format(R"(, "average_records": {}, "format": {})",
                           json_number(view.records.average),
                           quoted_label(cache_format_labels, view.records.format));
}

std::string format_view(const ViewState& view) {
  return fmt::format(
      "{{\n    \"shown\": {}, \"shadows\": {}, \"exposure\": {}, \"curve\": {}, "
      "\"false_color\": {}, \"heat_range\": {},\n    \"frame_ms\": {}, \"refine\": {}, \"zoom\": "
      "{}, "
      "\"zoom_center\": [{}, {}],\n    {}\n  }}",
      quoted_label(shown_picture_labels, view.shown),
      quoted_label(shadow_method_labels, view.shadows), json_number(view.display.exposure),
      quoted_label(tone_curve_labels, view.display.curve), view.false_color,
      quoted_label(heat_range_labels, view.heat_range), json_number(view.frame_ms), view.refine,
      json_number(view.zoom), json_number(view.zoom_center_px.x),
      json_number(view.zoom_center_px.y), format_trade(view));
}

std::string format_solo(const ViewState& view) {
  std::string out;
  for (const int light : view.solo_lights) {
    if (light < 0 || light >= static_cast<int>(view.lights.size())) continue;
    out += (out.empty() ? "" : ", ") + json_quoted(view.lights[static_cast<size_t>(light)].name);
  }
  return "[" + out + "]";
}

/// The list of format_lights() without the object around it.
std::string format_light_list(const std::vector<Light>& lights) {
  const std::string text = format_lights(lights);
  const size_t first = text.find('[');
  return text.substr(first, text.rfind(']') + 1 - first);
}

template <class Value>
void read_integer(const JsonNode& node, const char* key, Value& value, int64_t low, int64_t high) {
  if (const auto found = node.find(key)) value = static_cast<int>(found->integer(low, high));
}

void read_prepare(const JsonNode& node, SessionFile& session) {
  node.expect_keys({"spp", "method", "format", "preset", "records", "members", "average_records",
                    "target_error", "frame_ms", "predict_error", "training_lights", "train_shadows",
                    "width", "height", "seed"});
  PrepareOptions& prepare = session.prepare;
  read_integer(node, "spp", prepare.spp, 1, 1024);
  node.read("method", prepare.method, reduction_method_labels);
  if (const auto format = node.find("format")) prepare.format = format->label(cache_format_labels);
  node.read("frame_ms", prepare.frame_ms, 0, max_frame_ms);
  node.read("preset", prepare.preset, reduction_preset_labels);
  read_integer(node, "records", prepare.records, 1, 64);
  read_integer(node, "members", prepare.members, 0, max_members);
  node.read("average_records", prepare.budget.average_records, 0.01f, 64);
  node.read("target_error", prepare.budget.target_error, 1e-6f, 1);
  node.read("predict_error", prepare.predict_error);
  read_integer(node, "training_lights", prepare.training_lights, 1, 4096);
  node.read("train_shadows", prepare.train_shadows);
  read_integer(node, "width", prepare.width, 0, max_image_side);
  read_integer(node, "height", prepare.height, 0, max_image_side);
  node.read_seed("seed", session.seed);
}

void read_trade(const JsonNode& node, ViewState& view) {
  node.read("trade", view.trade.kind, trade_kind_labels);
  node.read("trade_level", view.trade.level, 0, 1);
  node.read("trade_ms", view.trade.move_ms, least_trade_ms, max_frame_ms);
  node.read("trade_error", view.trade.target_error, least_trade_error, 1);
  node.read("average_records", view.records.average, 0.01f, 64);
  node.read("format", view.records.format, cache_format_labels);
}

void read_view(const JsonNode& node, ViewState& view) {
  node.expect_keys({"shown", "shadows", "exposure", "curve", "false_color", "heat_range",
                    "frame_ms", "refine", "zoom", "zoom_center", "trade", "trade_level", "trade_ms",
                    "trade_error", "average_records", "format"});
  node.read("shown", view.shown, shown_picture_labels);
  node.read("shadows", view.shadows, shadow_method_labels);
  node.read("exposure", view.display.exposure, -max_stops, max_stops);
  node.read("curve", view.display.curve, tone_curve_labels);
  node.read("false_color", view.false_color);
  node.read("heat_range", view.heat_range, heat_range_labels);
  node.read("frame_ms", view.frame_ms, 0, max_frame_ms);
  node.read("refine", view.refine);
  read_trade(node, view);
  node.read("zoom", view.zoom, 0, max_zoom);
  if (const auto center = node.find("zoom_center")) {
    view.zoom_center_px = center->pair(-max_coordinate, max_coordinate);
  }
}

/// The light that `node` names.
int find_light(const JsonNode& node, const std::vector<Light>& lights) {
  const std::string name = node.text(max_name_length);
  const auto found = std::find_if(lights.begin(), lights.end(),
                                  [&](const Light& light) { return light.name == name; });
  if (found == lights.end()) throw node.error("names no light", "give the name of one");
  return static_cast<int>(found - lights.begin());
}

void read_solo(const JsonNode& node, ViewState& view) {
  for (const JsonNode& item : node.items(max_lights)) {
    const int light = find_light(item, view.lights);
    const auto place = std::lower_bound(view.solo_lights.begin(), view.solo_lights.end(), light);
    if (place == view.solo_lights.end() || *place != light) view.solo_lights.insert(place, light);
  }
}

}  // namespace

std::string format_session(const SessionFile& session) {
  const ViewState& view = session.view;
  std::string out = fmt::format(
      "{{\n  \"schema\": \"{}\",\n  \"input\": {},\n  \"prepare\": {},\n  \"lights\": {},\n",
      session_schema, json_quoted(session.input), format_prepare(session),
      format_light_list(view.lights));
  if (!view.solo_lights.empty()) out += "  \"solo\": " + format_solo(view) + ",\n";
  if (view.selected_light >= 0 && view.selected_light < static_cast<int>(view.lights.size())) {
    const Light& light = view.lights[static_cast<size_t>(view.selected_light)];
    out += "  \"selected\": " + json_quoted(light.name) + ",\n";
  }
  return out + "  \"view\": " + format_view(view) + "\n}\n";
}

SessionFile parse_session(const std::string& text, const std::string& place) {
  if (text.size() > max_session_bytes) {
    throw limit_error(place, fmt::format("{} bytes is too large", text.size()),
                      fmt::format("the limit is {} bytes", max_session_bytes));
  }
  const JsonDocument document(text, place);
  const JsonNode root = document.root();
  root.expect_keys({"$schema", "schema", "input", "prepare", "lights", "solo", "selected", "view"});
  const JsonNode schema = root.get("schema", fmt::format("give \"{}\"", session_schema));
  if (schema.text(max_name_length) != session_schema) {
    throw schema.error("is not known to this program", fmt::format("give \"{}\"", session_schema));
  }
  SessionFile session;
  session.input = root.get("input", "give the scene or cache").text(max_path_length);
  if (const auto prepare = root.find("prepare")) read_prepare(*prepare, session);
  session.view.lights = read_lights(root.get("lights", "give \"lights\": [ ... ]"), std::nullopt);
  if (const auto solo = root.find("solo")) read_solo(*solo, session.view);
  session.view.selected_light = session.view.lights.empty() ? -1 : 0;
  if (const auto selected = root.find("selected")) {
    session.view.selected_light = find_light(*selected, session.view.lights);
  }
  if (const auto view = root.find("view")) read_view(*view, session.view);
  return session;
}

bool is_session(const std::string& text) {
  // Also true for a broken one, so that the message is about the session.
  return text.substr(0, 4096).find("\"relume-session-") != std::string::npos;
}

}  // namespace relume
