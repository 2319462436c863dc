#include "viewer/panels/inspector.h"

#include <fmt/format.h>

#include <optional>

#include "core/base/error.h"
#include "core/math/color.h"
#include "viewer/panels/widgets.h"
#include "viewer/session/false_color.h"
#include "viewer/session/pixel_maps.h"

namespace relume {
namespace {

constexpr size_t max_rows = 12;
constexpr ImU32 back_color = IM_COL32(18, 18, 18, 240);

std::string color_text(vec3 c) {
  return fmt::format("{:8.4f} {:8.4f} {:8.4f}", c.x, c.y, c.z);
}

/// The pixel under the pointer.
std::optional<ivec2> pointed_pixel(const UiState& ui, const SessionInfo& info) {
  const vec2 mouse = from_im(ImGui::GetIO().MousePos);
  if (!ImGui::IsMousePosValid() || !ui.layout.picture.contains(mouse)) return std::nullopt;
  const vec2 film = glm::floor(ui.placement.film_from_screen(mouse));
  const bool is_inside = film.x >= 0 && film.y >= 0 && film.x < static_cast<float>(info.width) &&
                         film.y < static_cast<float>(info.height);
  return is_inside ? std::optional(ivec2(film)) : std::nullopt;
}

struct Line {
  std::string label;
  std::string value;
  ImU32 color = IM_COL32(215, 215, 215, 255);
};

void add_frame_lines(const Session& session, ivec2 pixel, std::vector<Line>& lines) {
  const Image* image = session.shown_image();
  if (image == nullptr) return;
  const vec3 c = image->rgb(static_cast<size_t>(pixel.y) * image->width + pixel.x);
  lines.push_back(
      {session.status().refined ? "all samples" : "picture", color_text(c), IM_COL32_WHITE});
  const float stops = std::log2(luminance(c) / middle_grey);
  lines.push_back({"", is_finite(stops) ? fmt::format("{:+.2f} stops from grey", stops) : "black"});
}

void add_light_lines(const Session& session, const PixelReport& report, std::vector<Line>& lines) {
  const std::vector<Light>& lights = session.view().lights;
  for (size_t i = 0; i < lights.size() && i < max_rows; ++i) {
    const ImU32 color = static_cast<int>(i) == session.view().selected_light
                            ? accent_color
                            : IM_COL32(215, 215, 215, 255);
    lines.push_back({printable(lights[i].name, 14), color_text(report.light_values[i]), color});
  }
  if (lights.size() > max_rows) {
    lines.push_back({fmt::format("{} more lights", lights.size() - max_rows), ""});
  }
}

void add_record_lines(const Session& session, const PixelReport& report, std::vector<Line>& lines) {
  const CameraRays& rays = session.rays();
  for (size_t i = 0; i < report.records.size() && i < max_rows; ++i) {
    const InspectedRecord& record = report.records[i];
    lines.push_back({fmt::format("{}  {:.3f}", record.type, record.weight),
                     fmt::format("{}  at {:.4g}", color_text(record.radiance),
                                 rays.project(record.position).depth),
                     IM_COL32(165, 195, 225, 255)});
  }
  if (report.records.size() > max_rows) {
    lines.push_back({fmt::format("{} more records", report.records.size() - max_rows), ""});
  }
}

std::vector<Line> make_lines(const Session& session, ivec2 pixel) {
  std::vector<Line> lines;
  const size_t index = static_cast<size_t>(pixel.y) * session.info().width + pixel.x;
  lines.push_back({fmt::format("pixel {}, {}", pixel.x, pixel.y), "", accent_color});
  add_frame_lines(session, pixel, lines);
  if (!session.info().predicted_error.empty()) {
    lines.push_back(
        {"expected error", fmt::format("{:8.4f}", session.info().predicted_error[index])});
  }
  if (session.cache() == nullptr) return lines;
  const ViewState& view = session.view();
  const Tracer* tracer = view.shadows == ShadowMethod::none ? nullptr : session.tracer();
  const PixelReport report =
      inspect_pixel(*session.cache(), tracer, shown_lights(view), pixel.x, pixel.y);
  lines.push_back(
      {"coverage", fmt::format("{:8.3f}   {} record{}", report.coverage, report.records.size(),
                               report.records.size() == 1 ? "" : "s")});
  add_light_lines(session, report, lines);
  if (session.cache()->info().has_emission) {
    lines.push_back({"emission", color_text(report.emission)});
  }
  add_record_lines(session, report, lines);
  return lines;
}

/// The curve of one channel.
void draw_channel(const Rect& area, const std::array<uint32_t, 256>& counts, uint32_t largest,
                  ImU32 color) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float scale = area.size().y / std::sqrt(static_cast<float>(std::max(1u, largest)));
  for (size_t i = 0; i < counts.size(); ++i) {
    const float left = area.min.x + area.size().x * static_cast<float>(i) / 256;
    const float right = area.min.x + area.size().x * static_cast<float>(i + 1) / 256;
    // Square roots, so that what is rare is seen.
    const float height = std::min(scale * std::sqrt(static_cast<float>(counts[i])), area.size().y);
    if (height > 0) list.AddRectFilled({left, area.max.y - height}, {right, area.max.y}, color);
  }
}

}  // namespace

void pixel_inspector(UiState& ui, const Session& session) {
  if (!ui.show_inspector) return;
  const float font = ImGui::GetFontSize();
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const auto pixel = pointed_pixel(ui, session.info());
  const std::vector<Line> lines =
      pixel ? make_lines(session, *pixel) : std::vector<Line>{{"point at a pixel", "", dim_color}};
  const vec2 corner = ui.layout.picture.min + vec2(1, 2.4f) * font;
  const float row = 1.25f * font;
  const vec2 size((pixel ? 29.0f : 10.0f) * font, row * static_cast<float>(lines.size()) + font);
  list.AddRectFilled(to_im(corner), to_im(corner + size), back_color, 0.3f * font);
  for (size_t i = 0; i < lines.size(); ++i) {
    const vec2 place = corner + vec2(0.6f * font, 0.5f * font + row * static_cast<float>(i));
    list.AddText(to_im(place), lines[i].color, lines[i].label.c_str());
    list.AddText({place.x + 9.5f * font, place.y}, lines[i].color, lines[i].value.c_str());
  }
  ui.items.note("inspector", {corner, corner + size});
}

void picture_histogram(UiState& ui, const Session& session, uint64_t session_number) {
  if (!ui.show_histogram) return;
  const Picture& picture = session.picture();
  const std::pair key(session_number, picture.version);
  if (ui.histogram_of != key) ui.histogram = make_histogram(picture.rgba);
  ui.histogram_of = key;
  const float font = ImGui::GetFontSize();
  const Rect& area = ui.layout.picture;
  const vec2 size(17 * font, 7 * font);
  const vec2 corner(area.max.x - size.x - font, area.min.y + font);
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.AddRectFilled(to_im(corner), to_im(corner + size), back_color, 0.3f * font);
  const Rect plot{corner + vec2(0.5f * font), corner + size - vec2(0.5f, 1.8f) * font};
  constexpr std::array<ImU32, 3> colors = {IM_COL32(230, 60, 50, 120), IM_COL32(60, 200, 70, 120),
                                           IM_COL32(70, 110, 240, 120)};
  for (size_t c = 0; c < 3; ++c) {
    draw_channel(plot, ui.histogram.counts[c], ui.histogram.largest, colors[c]);
  }
  list.AddRect(to_im(plot.min), to_im(plot.max), IM_COL32(80, 80, 80, 255));
  const std::string text =
      fmt::format("black {:.1f} %   clipped {:.1f} %", 100 * ui.histogram.black_share,
                  100 * ui.histogram.clipped_share);
  list.AddText({plot.min.x, plot.max.y + 0.3f * font}, IM_COL32(215, 215, 215, 255), text.c_str());
  ui.items.note("histogram", {corner, corner + size});
}

}  // namespace relume
