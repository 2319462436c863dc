#include "viewer/display/frame_view.h"

namespace relume {
namespace {

constexpr const char* vertex_source = R"(#version 330 core
uniform vec4 rectangle;  // left, top, right, bottom in clip space
out vec2 uv;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  uv = corner;
  gl_Position = vec4(mix(rectangle.xy, rectangle.zw, corner), 0.0, 1.0);
}
)";

constexpr const char* fragment_source = R"(#version 330 core
uniform sampler2D picture;
in vec2 uv;
out vec4 color;
void main() { color = vec4(texture(picture, uv).rgb, 1.0); }
)";

}  // namespace

FrameView::FrameView(const GlTable& gl) : gl_(gl) {
  program_ = link_program(gl_, vertex_source, fragment_source);
  rectangle_uniform_ = gl_.GetUniformLocation(program_, "rectangle");
  gl_.GenVertexArrays(1, &vertex_array_);
  gl_.GenTextures(1, &texture_);
  gl_.BindTexture(GL_TEXTURE_2D, texture_);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

FrameView::~FrameView() {
  gl_.DeleteTextures(1, &texture_);
  gl_.DeleteVertexArrays(1, &vertex_array_);
  gl_.DeleteProgram(program_);
}

void FrameView::upload(const Picture& picture) {
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
  if (picture.width != width_ || picture.height != height_) {
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, picture.width, picture.height, 0, GL_RGBA,
                   GL_UNSIGNED_BYTE, picture.rgba.data());
    width_ = picture.width;
    height_ = picture.height;
  } else {
    gl_.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE,
                      picture.rgba.data());
  }
  version_ = picture.version;
}

void FrameView::draw(const Picture& picture, const Rect& target, const Rect& clip, ivec2 size_px) {
  const vec2 clip_min = glm::clamp(glm::floor(clip.min), vec2(0), vec2(size_px));
  const vec2 clip_max = glm::clamp(glm::ceil(clip.max), vec2(0), vec2(size_px));
  const vec2 clip_size = clip_max - clip_min;
  if (picture.rgba.empty() || !(clip_size.x > 0) || !(clip_size.y > 0)) return;

  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, texture_);
  if (picture.version != version_) upload(picture);
  const float scale = (target.max.x - target.min.x) / static_cast<float>(picture.width);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, scale >= 2 ? GL_NEAREST : GL_LINEAR);

  gl_.Viewport(0, 0, size_px.x, size_px.y);
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.Scissor(static_cast<int>(clip_min.x), size_px.y - static_cast<int>(clip_max.y),
              static_cast<int>(clip_size.x), static_cast<int>(clip_size.y));
  gl_.Disable(GL_BLEND);
  gl_.UseProgram(program_);
  const vec2 to_clip_space = vec2(2, -2) / vec2(size_px);
  const vec2 low = target.min * to_clip_space + vec2(-1, 1);
  const vec2 high = target.max * to_clip_space + vec2(-1, 1);
  gl_.Uniform4f(rectangle_uniform_, low.x, low.y, high.x, high.y);
  gl_.BindVertexArray(vertex_array_);
  gl_.DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  gl_.Disable(GL_SCISSOR_TEST);
}

}  // namespace relume
