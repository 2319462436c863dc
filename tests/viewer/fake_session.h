#pragma once

#include <memory>
#include <thread>

#include "viewer/session/session.h"

namespace relume {

/// A picture that needs no scene: each light is a soft spot where its position falls on the film,
/// and shadows darken the left half. Exact functions of the request, so tests can say what they
/// expect.
class SpotSource final : public FrameSource {
 public:
  SpotSource(const Camera& camera, int width, int height, float ripple)
      : rays_(camera, width, height), width_(width), height_(height), ripple_(ripple) {}

  void render(const RelightRequest& request, const std::atomic<bool>&, RelitFrame& frame) override {
    frame.image = Image(width_, height_);
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const vec3 color = shade(request, vec2(x, y) + 0.5f);
        for (int c = 0; c < 3; ++c) frame.image.at(x, y)[c] = color[c];
      }
    }
    frame.stats.layers_shaded = static_cast<int>(request.lights.size());
  }

 private:
  vec3 shade(const RelightRequest& request, vec2 film_px) const {
    vec3 sum(0);
    for (const Light& light : request.lights) {
      const vec2 center = rays_.project(light.position).film_px;
      const float distance = glm::distance(center, film_px) / static_cast<float>(height_);
      sum += light.weight() / (1.0f + 60.0f * distance * distance);
    }
    const bool shadowed =
        request.shadows == ShadowMethod::ray && film_px.x < 0.5f * static_cast<float>(width_);
    const float wave = 1 + ripple_ * std::sin(0.2f * film_px.x) * std::sin(0.2f * film_px.y);
    return sum * (shadowed ? 0.5f : 1.0f) * wave;
  }

  CameraRays rays_;
  int width_;
  int height_;
  float ripple_;
};

struct FakeSessionOptions {
  int width = 320;
  int height = 240;
  bool reference = true;
  bool predicted_error = true;
};

/// Two lights before a camera on the z axis; light 1 is in the middle of the view plane at depth 5.
/// Records rise from 0 to 19 rightwards, predicted errors from 0 to 0.2 downwards.
inline SessionParts make_fake_parts(const FakeSessionOptions& options = {}) {
  SessionParts parts;
  SessionInfo& info = parts.info;
  info.title = "spots";
  info.width = options.width;
  info.height = options.height;
  info.bounds.extend(vec3(-1));
  info.bounds.extend(vec3(1));
  info.method = "strong-kmeans";
  info.records = 4;
  info.spp = 25;
  info.record_count = 123456;
  info.can_trace = true;
  info.has_members = true;
  for (int y = 0; y < info.height; ++y) {
    for (int x = 0; x < info.width; ++x) {
      info.record_counts.push_back(static_cast<float>(20 * x / info.width));
      if (!options.predicted_error) continue;
      info.predicted_error.push_back(0.2f * static_cast<float>(y) /
                                     static_cast<float>(info.height));
    }
  }
  Light key;
  key.name = "key";
  key.position = vec3(0, 0, 0);
  key.color = vec3(1, 0.8f, 0.5f);
  Light fill;
  fill.name = "fill";
  fill.position = vec3(-1, 0.75f, 0.5f);
  fill.color = vec3(0.3f, 0.5f, 1);
  fill.gain = 0.5f;
  parts.view.lights = {key, fill};
  parts.view.selected_light = 0;
  parts.frames = std::make_unique<SpotSource>(info.camera, info.width, info.height, 0.0f);
  if (options.reference) {
    parts.reference = std::make_unique<SpotSource>(info.camera, info.width, info.height, 0.25f);
  }
  return parts;
}

}  // namespace relume
