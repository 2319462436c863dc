#include "viewer/display/ui_renderer.h"

#include <imgui.h>

#include <cstddef>

#include "core/math/vec.h"

namespace relume {
namespace {

constexpr const char* vertex_source = R"(#version 330 core
uniform vec4 rectangle;  // left, top, width, height of the display in ImGui's units
layout(location = 0) in vec2 position;
layout(location = 1) in vec2 vertex_uv;
layout(location = 2) in vec4 vertex_color;
out vec2 uv;
out vec4 tint;
void main() {
  uv = vertex_uv;
  tint = vertex_color;
  vec2 unit = (position - rectangle.xy) / rectangle.zw;
  gl_Position = vec4(2.0 * unit.x - 1.0, 1.0 - 2.0 * unit.y, 0.0, 1.0);
}
)";

constexpr const char* fragment_source = R"(#version 330 core
uniform sampler2D image;
in vec2 uv;
in vec4 tint;
out vec4 color;
void main() { color = tint * texture(image, uv); }
)";

const void* buffer_offset(size_t bytes) {
  return reinterpret_cast<const void*>(bytes);
}

}  // namespace

UiRenderer::UiRenderer(const GlTable& gl) : gl_(gl) {
  program_ = link_program(gl_, vertex_source, fragment_source);
  rectangle_uniform_ = gl_.GetUniformLocation(program_, "rectangle");
  make_vertex_layout();
  upload_fonts();
  ImGuiIO& io = ImGui::GetIO();
  io.BackendRendererName = "relume";
  io.BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
}

UiRenderer::~UiRenderer() {
  gl_.DeleteTextures(1, &fonts_);
  gl_.DeleteBuffers(1, &indices_);
  gl_.DeleteBuffers(1, &vertices_);
  gl_.DeleteVertexArrays(1, &vertex_array_);
  gl_.DeleteProgram(program_);
}

void UiRenderer::make_vertex_layout() {
  gl_.GenVertexArrays(1, &vertex_array_);
  gl_.GenBuffers(1, &vertices_);
  gl_.GenBuffers(1, &indices_);
  gl_.BindVertexArray(vertex_array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, vertices_);
  gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
  for (const GLuint location : {0u, 1u, 2u}) gl_.EnableVertexAttribArray(location);
  constexpr GLsizei stride = sizeof(ImDrawVert);
  gl_.VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, stride,
                          buffer_offset(offsetof(ImDrawVert, pos)));
  gl_.VertexAttribPointer(1, 2, GL_FLOAT, GL_FALSE, stride,
                          buffer_offset(offsetof(ImDrawVert, uv)));
  gl_.VertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, stride,
                          buffer_offset(offsetof(ImDrawVert, col)));
}

void UiRenderer::upload_fonts() {
  ImGuiIO& io = ImGui::GetIO();
  unsigned char* pixels = nullptr;
  int width = 0;
  int height = 0;
  io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
  gl_.GenTextures(1, &fonts_);
  gl_.BindTexture(GL_TEXTURE_2D, fonts_);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
  io.Fonts->SetTexID(reinterpret_cast<ImTextureID>(static_cast<intptr_t>(fonts_)));
}

void UiRenderer::draw(const ImDrawData& data) {
  const vec2 scale(data.FramebufferScale.x, data.FramebufferScale.y);
  const vec2 origin(data.DisplayPos.x, data.DisplayPos.y);
  const ivec2 size_px(vec2(data.DisplaySize.x, data.DisplaySize.y) * scale);
  if (size_px.x <= 0 || size_px.y <= 0) return;

  gl_.Viewport(0, 0, size_px.x, size_px.y);
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.Enable(GL_BLEND);
  gl_.BlendEquation(GL_FUNC_ADD);
  gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  gl_.UseProgram(program_);
  gl_.Uniform4f(rectangle_uniform_, origin.x, origin.y, data.DisplaySize.x, data.DisplaySize.y);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindVertexArray(vertex_array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, vertices_);

  for (int i = 0; i < data.CmdListsCount; ++i) {
    const ImDrawList& list = *data.CmdLists[i];
    gl_.BufferData(GL_ARRAY_BUFFER, list.VtxBuffer.size_in_bytes(), list.VtxBuffer.Data,
                   GL_STREAM_DRAW);
    gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER, list.IdxBuffer.size_in_bytes(), list.IdxBuffer.Data,
                   GL_STREAM_DRAW);
    for (const ImDrawCmd& command : list.CmdBuffer) {
      const ImVec4& clip = command.ClipRect;
      const ivec2 low = glm::max(ivec2((vec2(clip.x, clip.y) - origin) * scale), ivec2(0));
      const ivec2 high = glm::min(ivec2((vec2(clip.z, clip.w) - origin) * scale), size_px);
      if (high.x <= low.x || high.y <= low.y || command.ElemCount == 0) continue;
      gl_.Scissor(low.x, size_px.y - high.y, high.x - low.x, high.y - low.y);
      gl_.BindTexture(GL_TEXTURE_2D,
                      static_cast<GLuint>(reinterpret_cast<intptr_t>(command.GetTexID())));
      gl_.DrawElementsBaseVertex(GL_TRIANGLES, static_cast<GLsizei>(command.ElemCount),
                                 sizeof(ImDrawIdx) == 2 ? GL_UNSIGNED_SHORT : GL_UNSIGNED_INT,
                                 buffer_offset(command.IdxOffset * sizeof(ImDrawIdx)),
                                 static_cast<GLint>(command.VtxOffset));
    }
  }
  gl_.Disable(GL_SCISSOR_TEST);
  gl_.Disable(GL_BLEND);
}

}  // namespace relume
