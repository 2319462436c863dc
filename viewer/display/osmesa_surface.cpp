#include "viewer/display/osmesa_surface.h"

// After our header: it brings GL/gl.h, which defines less than the core header of the table.
#include <GL/osmesa.h>
#include <dlfcn.h>

#include <cstdlib>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"

#if defined(__SANITIZE_ADDRESS__)
/// Mesa keeps a few bytes for each context and size until the process ends.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libOSMesa.so\n";
}
#endif

namespace relume {
namespace {

constexpr const char* library_file = "libOSMesa.so.8";
constexpr const char* install_mend = "apt-get install libosmesa6";

/// The functions of libOSMesa that we call.
struct Library {
  decltype(&OSMesaCreateContextAttribs) create_context = nullptr;
  decltype(&OSMesaDestroyContext) destroy_context = nullptr;
  decltype(&OSMesaMakeCurrent) make_current = nullptr;
  decltype(&OSMesaGetProcAddress) get_function = nullptr;
};

template <class Function>
void load_function(void* handle, const char* name, Function& function) {
  function = reinterpret_cast<Function>(dlsym(handle, name));
  if (function == nullptr) {
    throw output_error(library_file, std::string(name) + " is missing", install_mend);
  }
}

Library load_library() {
  // Mesa's drawing threads unlock a fence that the caller may have freed already, where it comes
  // just between their last count and the unlocking (Mesa 22.3, lp_fence_signal): the heap breaks,
  // seldom, on a busy machine. Without them the caller draws by itself.
  setenv("LP_NUM_THREADS", "0", /*overwrite=*/0);
  // Never closed: drivers do not survive it.
  void* handle = dlopen(library_file, RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) throw output_error(library_file, "cannot be loaded", install_mend);
  Library library;
  load_function(handle, "OSMesaCreateContextAttribs", library.create_context);
  load_function(handle, "OSMesaDestroyContext", library.destroy_context);
  load_function(handle, "OSMesaMakeCurrent", library.make_current);
  load_function(handle, "OSMesaGetProcAddress", library.get_function);
  return library;
}

const Library& osmesa() {
  static const Library library = load_library();
  return library;
}

GlFunction load_gl_function(const char* name) {
  return osmesa().get_function(name);
}

OSMesaContext make_context() {
  const int attributes[] = {OSMESA_FORMAT,
                            OSMESA_RGBA,
                            OSMESA_PROFILE,
                            OSMESA_CORE_PROFILE,
                            OSMESA_CONTEXT_MAJOR_VERSION,
                            3,
                            OSMESA_CONTEXT_MINOR_VERSION,
                            3,
                            0,
                            0};
  OSMesaContext context = osmesa().create_context(attributes, nullptr);
  if (context == nullptr) {
    throw output_error("off-screen drawing", "there is no OpenGL 3.3 context", install_mend);
  }
  return context;
}

void destroy_context(OSMesaContext context) {
  osmesa().make_current(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
  if (context != nullptr) osmesa().destroy_context(context);
}

}  // namespace

struct OsmesaSurface::Impl {
  OSMesaContext context = nullptr;
  ivec2 size_px{0};
  std::vector<uint8_t> pixels;
};

OsmesaSurface::OsmesaSurface(ivec2 size_px) : impl_(std::make_unique<Impl>()) {
  impl_->context = make_context();
  resize(size_px);
}

OsmesaSurface::~OsmesaSurface() {
  destroy_context(impl_->context);
}

void OsmesaSurface::renew_context() {
  destroy_context(std::exchange(impl_->context, nullptr));
  impl_->context = make_context();
  resize(impl_->size_px);
}

GlLoader OsmesaSurface::loader() const {
  return load_gl_function;
}

ivec2 OsmesaSurface::size_px() const {
  return impl_->size_px;
}

void OsmesaSurface::present() {
  const auto finish = reinterpret_cast<void (*)()>(load_gl_function("glFinish"));
  CHECK(finish != nullptr);
  finish();
}

void OsmesaSurface::resize(ivec2 size_px) {
  const ivec2 size = glm::clamp(size_px, ivec2(1), ivec2(16384));
  std::vector<uint8_t> pixels(4 * static_cast<size_t>(size.x) * size.y);
  if (!osmesa().make_current(impl_->context, pixels.data(), GL_UNSIGNED_BYTE, size.x, size.y)) {
    throw output_error("off-screen drawing", "the context cannot be made current", install_mend);
  }
  impl_->pixels = std::move(pixels);
  impl_->size_px = size;
}

}  // namespace relume
