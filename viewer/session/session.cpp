#include "viewer/session/session.h"

#include <fmt/format.h>

#include <utility>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/image/heatmap.h"
#include "viewer/session/pixel_maps.h"
#include "viewer/session/visibility_source.h"

namespace relume {
namespace {

/// What a light move at rest may take with `automatic` shadows; then traced samples follow.
constexpr float rest_ms = 1000;
constexpr float ten_times_range = 0.1f;

/// True when both ask for the same picture, at whatever quality.
bool same_picture(const RelightRequest& a, const RelightRequest& b) {
  return a.shadows == b.shadows && same_lighting(a.lights, b.lights);
}

/// What is wrong with the first light that cannot be used; empty when all can.
std::string find_problem(std::span<const Light> lights) {
  try {
    for (size_t i = 0; i < lights.size(); ++i)
      validate_light(lights[i], fmt::format("light {}", i + 1));
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

double predicted_mean(const SessionInfo& info) {
  return info.predicted_error.empty() ? 0 : mean_covered(info.predicted_error, info.coverage);
}

}  // namespace

Session::Session(SessionParts parts)
    : scene_(std::move(parts.scene)),
      tracer_(std::move(parts.tracer)),
      info_(std::move(parts.info)),
      rays_(info_.camera, info_.width, info_.height),
      view_(std::move(parts.view)) {
  CHECK(parts.frames != nullptr);
  cache_ = parts.frames->cache();
  const size_t pixels = static_cast<size_t>(info_.width) * info_.height;
  CHECK_MSG(info_.record_counts.size() == pixels, "{} of {}", info_.record_counts.size(), pixels);
  connect(frame_, std::move(parts.frames));
  connect(visibility_, std::move(parts.visibility));
  info_.has_reference = false;
  info_.predicted_mean = predicted_mean(info_);
  if (parts.reference) set_reference(std::move(parts.reference));
}

Session::~Session() = default;

void Session::set_notify(const std::function<void()>& notify) {
  notify_ = notify;
  frame_.worker->set_notify(notify);
  if (reference_.worker) reference_.worker->set_notify(notify);
  if (visibility_.worker) visibility_.worker->set_notify(notify);
}

void Session::set_reference(std::unique_ptr<FrameSource> source) {
  CHECK(source != nullptr && reference_.worker == nullptr);
  reference_cache_ = source->cache();
  connect(reference_, std::move(source));
  info_.has_reference = true;
}

void Session::connect(Channel& channel, std::unique_ptr<FrameSource> source) {
  channel.worker.reset();
  channel.asked.reset();
  if (!source) return;
  channel.worker = std::make_unique<RelightWorker>(std::move(source));
  channel.worker->set_notify(notify_);
}

void Session::set_records(SessionRecords records) {
  CHECK(records.frames != nullptr);
  CHECK(records.info.width == info_.width && records.info.height == info_.height);
  for (Channel* channel : {&frame_, &visibility_}) {
    if (!channel->worker) continue;
    channel->worker->set_notify({});
    channel->worker->stop();
  }
  // A running frame may take its time. The visibility uses the frame's cache and goes first.
  retired_ = std::async(std::launch::async, [frames = std::move(frame_.worker),
                                             visibility = std::move(visibility_.worker)]() mutable {
    visibility.reset();
    frames.reset();
  });
  records.info.has_reference = info_.has_reference;
  info_ = std::move(records.info);
  info_.predicted_mean = predicted_mean(info_);
  cache_ = records.frames->cache();
  connect(frame_, std::move(records.frames));
  connect(visibility_, std::move(records.visibility));
  visibility_.version = 0;
  budget_ = {};
  ++records_number_;
}

void Session::update(bool resting) {
  ask(resting);
  take();
  paint(resting);
}

void Session::wait(bool resting) {
  bool asked = true;
  while (asked) {
    asked = ask(resting);
    frame_.worker->wait_idle();
    if (reference_.worker) reference_.worker->wait_idle();
    if (visibility_.worker) visibility_.worker->wait_idle();
    take();
  }
  paint(resting);
}

bool Session::ask(bool resting) {
  view_problem_ = find_problem(view_.lights);
  if (!view_problem_.empty()) return false;
  const bool asked_frame = ask_frame(resting);
  const bool asked_reference = ask_reference(resting);
  return ask_visibility() || asked_reference || asked_frame;
}

/// A picture that was not asked for yet comes coarse when all of it would take too long; the rest
/// follows when that was taken, unless a newer picture is asked for meanwhile.
bool Session::ask_frame(bool resting) {
  RelightRequest request{shown_lights(view_), view_.shadows};
  request.dragging = !resting;
  request.frame_ms = request.dragging ? view_.frame_ms : rest_ms;
  const RelightRequest* before = frame_.version > 0 ? &frame_.latest.request : nullptr;
  if (!frame_.asked || !same_picture(*frame_.asked, request)) {
    request.pixels = budget_.choose_pixels(request, before, view_.frame_ms);
  } else if (frame_.asked->pixels == PixelShare::all) {
    if (request.dragging || !frame_.asked->dragging) return false;  // at rest lights sum in order
    request.may_stop = view_.shadows == ShadowMethod::automatic;    // whose shadows get finer
  } else if (before == nullptr || !same_picture(*before, request)) {
    return false;
  } else {
    request.may_stop = true;
  }
  submit(frame_, request);
  return true;
}

/// The reference is slow and nobody watches it while a light is dragged over the frame.
bool Session::ask_reference(bool resting) {
  if (!reference_.worker) return false;
  const RelightRequest request{
      .lights = shown_lights(view_), .shadows = ShadowMethod::ray, .may_stop = true};
  const bool is_asked = reference_.asked && same_picture(*reference_.asked, request);
  if (reference_.asked && !is_asked) {
    reference_.worker->stop();
    reference_.asked.reset();
  }
  const bool completes_frame = view_.shown == ShownPicture::frame && view_.refine &&
                               view_.shadows != ShadowMethod::none && frame_is_current() &&
                               frame_.latest.request.pixels == PixelShare::all;
  const bool wanted = resting && (needs_reference(view_.shown) || completes_frame);
  if (is_asked || !wanted) return false;
  submit(reference_, request);
  return true;
}

const Light* Session::selected_light() const {
  const bool exists =
      view_.selected_light >= 0 && view_.selected_light < static_cast<int>(view_.lights.size());
  return exists ? &view_.lights[static_cast<size_t>(view_.selected_light)] : nullptr;
}

bool Session::ask_visibility() {
  const Light* light = selected_light();
  const bool wanted = view_.shown == ShownPicture::visibility && visibility_.worker && light;
  if (!wanted) return false;
  const RelightRequest request{.lights = {*light}, .shadows = view_.shadows, .may_stop = true};
  const bool is_asked = visibility_.asked && visibility_.asked->shadows == request.shadows &&
                        same_layer(visibility_.asked->lights[0], *light);
  if (!is_asked) submit(visibility_, request);
  return !is_asked;
}

void Session::submit(Channel& channel, const RelightRequest& request) {
  channel.asked = request;
  channel.worker->submit(request);
}

void Session::take() {
  const uint64_t version = frame_.version;
  take(frame_);
  if (frame_.version != version) budget_.add(frame_.latest);
  take(reference_);
  take(visibility_);
  status_.stats = frame_.latest.stats;
  status_.frame_ms = frame_.latest.ms;
  status_.shadows_used = frame_.latest.shadows_used;
  status_.pixels = frame_.version > 0 ? frame_.latest.request.pixels : PixelShare::none;
  status_.problem = view_problem_;
  if (status_.problem.empty()) status_.problem = frame_.problem;
  if (status_.problem.empty()) status_.problem = reference_.problem;
  if (status_.problem.empty()) status_.problem = visibility_.problem;
  status_.busy = frame_.worker->busy() || (reference_.worker && reference_.worker->busy()) ||
                 (visibility_.worker && visibility_.worker->busy());
}

void Session::take(Channel& channel) {
  if (!channel.worker || !channel.worker->take(channel.incoming)) return;
  channel.problem = channel.incoming.error;
  if (!channel.problem.empty()) return;
  std::swap(channel.latest, channel.incoming);
  ++channel.version;
}

bool Session::frame_is_current() const {
  const RelightRequest& shown = frame_.latest.request;
  return shown.shadows == view_.shadows && same_lighting(shown.lights, shown_lights(view_));
}

bool Session::reference_is_current() const {
  return reference_.version > 0 &&
         same_lighting(reference_.latest.request.lights, shown_lights(view_));
}

bool Session::visibility_is_current() const {
  const Light* light = selected_light();
  if (visibility_.version == 0 || light == nullptr) return false;
  const RelightRequest& shown = visibility_.latest.request;
  return shown.shadows == view_.shadows && same_layer(shown.lights[0], *light);
}

const Image* Session::shown_image() const {
  if (picture_.version == 0) return nullptr;
  if (status_.painted == ShownPicture::reference) return &reference_.latest.image;
  if (status_.painted != ShownPicture::frame) return nullptr;
  return status_.refined ? &reference_.latest.image : &frame_.latest.image;
}

bool Session::is_refined() const {
  return view_.refine && view_.shadows != ShadowMethod::none && reference_is_current();
}

ShownPicture Session::paintable() const {
  switch (view_.shown) {
    case ShownPicture::frame:
      break;
    case ShownPicture::reference:
      if (reference_is_current()) return ShownPicture::reference;
      break;
    case ShownPicture::difference:
    case ShownPicture::heatmap:
      if (reference_is_current() && frame_is_current()) return view_.shown;
      break;
    case ShownPicture::predicted:
      if (!info_.predicted_error.empty()) return ShownPicture::predicted;
      break;
    case ShownPicture::visibility:
      // Stays, a little behind, while the light moves.
      if (visibility_.version > 0 && selected_light() != nullptr) return view_.shown;
      break;
    case ShownPicture::type:
    case ShownPicture::normal:
      if (cache_ != nullptr) return view_.shown;
      break;
    case ShownPicture::records:
      return ShownPicture::records;
  }
  return ShownPicture::frame;
}

void Session::paint(bool resting) {
  if (frame_.version == 0) return;
  const ShownPicture shown = paintable();
  const bool refined = shown == ShownPicture::frame && is_refined();
  const bool is_whole = frame_.latest.request.pixels == PixelShare::all || refined;
  const bool shows_lights = frame_is_current() && is_whole;
  const bool is_current = shown == ShownPicture::visibility ? visibility_is_current()
                                                            : ignores_lights(shown) || shows_lights;
  status_.outdated = shown != view_.shown || !is_current;
  // A heatmap stays, marked as outdated, until the next one is there.
  if (shown != view_.shown && view_.shown == ShownPicture::heatmap &&
      status_.painted == ShownPicture::heatmap && picture_.version > 0) {
    return;
  }
  const bool needs_frame = shown == ShownPicture::frame || shown == ShownPicture::heatmap ||
                           shown == ShownPicture::difference;
  PaintKey key{shown,
               records_number_,
               view_.heat_range,
               view_.display.curve,
               view_.display.exposure,
               needs_frame && !refined ? frame_.version : 0,
               needs_reference(shown) || refined ? reference_.version : 0,
               refined,
               view_.false_color,
               shown == ShownPicture::visibility ? visibility_.version : 0,
               DisplayQuality::exact};
  if (painted_ == key) return;
  if (!resting && view_.display.curve == ToneCurve::config) key.quality = DisplayQuality::draft;
  if (painted_ == key) return;
  painted_ = key;
  status_.painted = shown;
  status_.refined = refined;
  status_.error.reset();
  status_.map_mean.reset();
  status_.heat_range = 0;
  switch (shown) {
    case ShownPicture::frame:
      paint_image(refined ? reference_.latest.image : frame_.latest.image);
      break;
    case ShownPicture::reference:
      paint_image(reference_.latest.image);
      break;
    case ShownPicture::heatmap:
      paint_heatmap();
      break;
    case ShownPicture::predicted:
      paint_map(info_.predicted_error);
      break;
    case ShownPicture::records:
      paint_map(info_.record_counts);
      break;
    case ShownPicture::difference:
      paint_difference();
      break;
    case ShownPicture::visibility:
      paint_map(visibility_.latest.image.pixels);
      break;
    case ShownPicture::type:
      paint_encoded(type_map(*cache_));
      break;
    case ShownPicture::normal:
      paint_encoded(normal_map(*cache_));
      break;
  }
  ++picture_.version;
}

void Session::paint_image(const Image& image) {
  picture_.width = image.width;
  picture_.height = image.height;
  display_image(image, view_, painted_->quality, picture_.rgba);
}

/// Ten times the frame minus the reference, around middle grey.
void Session::paint_difference() {
  Image shown = frame_.latest.image;
  const Image& reference = reference_.latest.image;
  for (size_t i = 0; i < shown.pixels.size(); ++i) {
    shown.pixels[i] = 0.5f + (shown.pixels[i] - reference.pixels[i]) / ten_times_range;
  }
  status_.error = compare_images(frame_.latest.image, reference_.latest.image, info_.coverage);
  paint_encoded(shown);
}

/// An image of display values in [0, 1], three channels.
void Session::paint_encoded(const Image& image) {
  picture_.width = image.width;
  picture_.height = image.height;
  picture_.rgba.resize(4 * image.pixel_count());
  for (size_t i = 0; i < image.pixel_count(); ++i) {
    const vec3 color = glm::clamp(image.rgb(i), 0.0f, 1.0f);
    for (int c = 0; c < 3; ++c) {
      picture_.rgba[4 * i + c] = static_cast<uint8_t>(255.0f * color[c] + 0.5f);
    }
    picture_.rgba[4 * i + 3] = 255;
  }
}

void Session::paint_heatmap() {
  const Image& frame = frame_.latest.image;
  const Image& reference = reference_.latest.image;
  const Image error = error_image(frame, reference);
  status_.error = compare_images(frame, reference, info_.coverage);
  paint_scaled(error);
}

void Session::paint_map(const std::vector<float>& values) {
  status_.map_mean = mean_covered(values, info_.coverage);
  paint_scaled(make_map(info_.width, info_.height, values));
}

void Session::paint_scaled(const Image& values) {
  if (status_.painted == ShownPicture::visibility) {
    status_.heat_range = 1;
  } else if (status_.painted == ShownPicture::records) {
    status_.heat_range = record_map_range(info_.records);
  } else {
    status_.heat_range =
        view_.heat_range == HeatRange::ten_times ? ten_times_range : automatic_range(values);
  }
  const DisplayImage heat =
      render_heatmap(values, {.range = status_.heat_range, .scale_bar = false});
  picture_.width = heat.width;
  picture_.height = heat.height;
  const size_t pixels = static_cast<size_t>(heat.width) * heat.height;
  picture_.rgba.resize(4 * pixels);
  for (size_t i = 0; i < pixels; ++i) {
    for (size_t c = 0; c < 3; ++c) picture_.rgba[4 * i + c] = heat.pixels[heat.channels * i + c];
    picture_.rgba[4 * i + 3] = 255;
  }
}

SessionRecords make_session_records(RelightCache frames, const Tracer* tracer) {
  const CacheInfo& cache = frames.info();
  SessionRecords records;
  records.info = {.title = cache.scene_name,
                  .width = cache.width,
                  .height = cache.height,
                  .camera = cache.camera,
                  .bounds = cache.bounds,
                  .method = cache.method,
                  .format = cache.format,
                  .records = cache.records,
                  .budget = {cache.average_records, cache.target_error},
                  .spp = cache.spp,
                  .record_count = cache.record_count,
                  .coverage = frames.coverage(),
                  .predicted_error = frames.predicted_error(),
                  .record_counts = frames.record_counts(),
                  .can_trace = tracer != nullptr,
                  .has_members = cache.has_members || !cache.has_footprints};
  records.frames = make_cache_source(std::move(frames), tracer);
  if (tracer != nullptr) {
    records.visibility = make_visibility_source(*records.frames->cache(), *tracer);
  }
  return records;
}

Session make_session(std::unique_ptr<const Scene> scene, std::unique_ptr<const Tracer> tracer,
                     RelightCache frames, std::optional<RelightCache> reference) {
  SessionParts parts;
  parts.view.lights = frames.info().lights;
  parts.view.selected_light = parts.view.lights.empty() ? -1 : 0;
  parts.view.shadows = tracer ? ShadowMethod::ray : ShadowMethod::none;
  parts.view.display.exposure = frames.info().exposure;
  SessionRecords records = make_session_records(std::move(frames), tracer.get());
  parts.info = std::move(records.info);
  parts.frames = std::move(records.frames);
  parts.visibility = std::move(records.visibility);
  if (reference && tracer) {
    parts.reference = make_cache_source(std::move(*reference), tracer.get(), ShadowMethod::ray);
  }
  parts.scene = std::move(scene);
  parts.tracer = std::move(tracer);
  return Session(std::move(parts));
}

}  // namespace relume
