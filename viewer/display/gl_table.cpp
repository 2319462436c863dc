#include "viewer/display/gl_table.h"

#include <fmt/format.h>

#include <array>

#include "core/base/error.h"

namespace relume {
namespace {

constexpr const char* driver_mend = "install or update the graphics driver, or use --offscreen DIR";

std::string text_of(const GlTable& gl, GLenum name) {
  const GLubyte* text = gl.GetString(name);
  return text == nullptr ? "unknown" : printable(reinterpret_cast<const char*>(text));
}

GLuint compile_shader(const GlTable& gl, GLenum stage, const char* source) {
  const GLuint shader = gl.CreateShader(stage);
  gl.ShaderSource(shader, 1, &source, nullptr);
  gl.CompileShader(shader);
  GLint compiled = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled != 0) return shader;
  std::array<char, 512> log{};
  gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  gl.DeleteShader(shader);
  throw output_error("OpenGL", fmt::format("a shader does not compile: {}", log.data()),
                     driver_mend);
}

}  // namespace

GlTable load_gl_table(GlLoader load) {
  GlTable gl;
#define RELUME_GL_LOAD(type, name)                                                \
  gl.name = reinterpret_cast<type>(load("gl" #name));                             \
  if (gl.name == nullptr) {                                                       \
    throw output_error("OpenGL", "function gl" #name " is missing", driver_mend); \
  }
  RELUME_GL_FUNCTIONS(RELUME_GL_LOAD)
#undef RELUME_GL_LOAD
  GLint major = 0;
  GLint minor = 0;
  gl.GetIntegerv(GL_MAJOR_VERSION, &major);
  gl.GetIntegerv(GL_MINOR_VERSION, &minor);
  if (major < 3 || (major == 3 && minor < 3)) {
    throw output_error("OpenGL", fmt::format("version {}.{} is below 3.3", major, minor),
                       driver_mend);
  }
  return gl;
}

std::string describe_gl(const GlTable& gl) {
  return fmt::format("{}, {}", text_of(gl, GL_VERSION), text_of(gl, GL_RENDERER));
}

void require_no_gl_error(const GlTable& gl, const std::string& where) {
  const GLenum error = gl.GetError();
  if (error == GL_NO_ERROR) return;
  throw output_error(where, fmt::format("OpenGL reports error 0x{:04x}", error), driver_mend);
}

GLuint link_program(const GlTable& gl, const char* vertex_source, const char* fragment_source) {
  const GLuint vertex = compile_shader(gl, GL_VERTEX_SHADER, vertex_source);
  const GLuint fragment = compile_shader(gl, GL_FRAGMENT_SHADER, fragment_source);
  const GLuint program = gl.CreateProgram();
  gl.AttachShader(program, vertex);
  gl.AttachShader(program, fragment);
  gl.LinkProgram(program);
  gl.DeleteShader(vertex);
  gl.DeleteShader(fragment);
  GLint linked = 0;
  gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
  if (linked != 0) return program;
  std::array<char, 512> log{};
  gl.GetProgramInfoLog(program, static_cast<GLsizei>(log.size()), nullptr, log.data());
  gl.DeleteProgram(program);
  throw output_error("OpenGL", fmt::format("a program does not link: {}", log.data()), driver_mend);
}

}  // namespace relume
