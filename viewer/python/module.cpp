// The Python module `relume`: the library's face (viewer/library/relume.h), pictures as NumPy
// arrays.

#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "viewer/library/relume.h"

namespace py = pybind11;
namespace api = relume::api;

namespace {

using InputArray = py::array_t<float, py::array::c_style | py::array::forcecast>;

std::vector<py::ssize_t> shape_of(int width, int height, int channels) {
  if (channels == 1) return {height, width};
  return {height, width, channels};
}

/// A read-only array over pixels that `owner` keeps.
py::array view_array(const api::ImageView& view, const py::object& owner) {
  py::array_t<float> array(shape_of(view.width, view.height, view.channels), view.pixels, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

/// An array that takes the image's pixels over.
py::array own_array(api::Image image) {
  auto kept = std::make_unique<api::Image>(std::move(image));
  const api::Image& pixels = *kept;
  const py::capsule owner(kept.get(), [](void* p) { delete static_cast<api::Image*>(p); });
  kept.release();
  return py::array_t<float>(shape_of(pixels.width, pixels.height, pixels.channels),
                            pixels.pixels.data(), owner);
}

api::ImageView view_of(const InputArray& array) {
  if (array.ndim() != 3) throw py::value_error("a picture has the shape (height, width, 3)");
  return {array.data(), static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)),
          static_cast<int>(array.shape(2))};
}

/// An object whose attributes are set by keyword.
template <class Settings>
Settings from_keywords(const py::kwargs& keywords) {
  const py::object object = py::cast(Settings{});
  for (const auto& [name, value] : keywords) py::setattr(object, name, value);
  return object.cast<Settings>();
}

/// Stops at Ctrl-C, which only the thread that holds the interpreter may ask about.
api::Progress interruptible(const py::object& callback) {
  return [callback](const std::string& stage, double fraction) {
    const py::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (callback.is_none()) return true;
    const py::object result = callback(stage, fraction);
    return result.is_none() || result.cast<bool>();
  };
}

api::Cache prepare(const std::string& scene, const py::object& progress,
                   const py::kwargs& settings) {
  const auto chosen = from_keywords<api::PrepareSettings>(settings);
  const api::Progress callback = interruptible(progress);
  const py::gil_scoped_release release;
  return api::Cache::prepare(scene, chosen, callback);
}

void bind_light(py::module_& module) {
  py::class_<api::Light>(module, "Light",
                         "A light; attributes and their meaning are those of a scene file's "
                         "(docs/scene-format.md).")
      .def(py::init([](const py::kwargs& keywords) { return from_keywords<api::Light>(keywords); }),
           "Light(type='spot', position=(0, 3, 0), gain=5): every attribute by keyword.")
      .def_readwrite("name", &api::Light::name)
      .def_readwrite("type", &api::Light::type, "point, spot or directional")
      .def_readwrite("position", &api::Light::position)
      .def_readwrite("direction", &api::Light::direction)
      .def_readwrite("inner_angle_deg", &api::Light::inner_angle_deg)
      .def_readwrite("outer_angle_deg", &api::Light::outer_angle_deg)
      .def_readwrite("falloff", &api::Light::falloff)
      .def_readwrite("range", &api::Light::range)
      .def_readwrite("color", &api::Light::color)
      .def_readwrite("gain", &api::Light::gain)
      .def_readwrite("mute", &api::Light::mute)
      .def_readwrite("casts_shadow", &api::Light::casts_shadow)
      .def("__repr__", [](const api::Light& light) {
        return "<relume.Light '" + light.name + "' " + light.type + ">";
      });
}

void bind_cache(py::module_& module) {
  py::class_<api::PrepareSettings>(module, "PrepareSettings",
                                   "What prepare() takes by keyword: the flags of relume prepare.")
      .def(py::init<>())
      .def_readwrite("method", &api::PrepareSettings::method)
      .def_readwrite("records", &api::PrepareSettings::records)
      .def_readwrite("average_records", &api::PrepareSettings::average_records)
      .def_readwrite("target_error", &api::PrepareSettings::target_error)
      .def_readwrite("spp", &api::PrepareSettings::spp)
      .def_readwrite("format", &api::PrepareSettings::format)
      .def_readwrite("members", &api::PrepareSettings::members)
      .def_readwrite("predict_error", &api::PrepareSettings::predict_error)
      .def_readwrite("width", &api::PrepareSettings::width)
      .def_readwrite("height", &api::PrepareSettings::height)
      .def_readwrite("seed", &api::PrepareSettings::seed);
  py::class_<api::Cache>(module, "Cache", "The prepared records of one view. Immutable.")
      .def("save", &api::Cache::save, py::arg("path"), "Writes a .relume file.")
      .def_property_readonly("width", &api::Cache::width)
      .def_property_readonly("height", &api::Cache::height)
      .def_property_readonly("scene", &api::Cache::scene)
      .def_property_readonly("method", &api::Cache::method)
      .def_property_readonly("spp", &api::Cache::spp)
      .def_property_readonly("sample_count", &api::Cache::sample_count)
      .def_property_readonly("record_count", &api::Cache::record_count)
      .def_property_readonly("hash", &api::Cache::hash)
      .def_property_readonly("lights", &api::Cache::lights, "The scene's lights, a new list.")
      .def_property_readonly(
          "coverage", [](const api::Cache& cache) { return own_array(cache.coverage()); },
          "(height, width), the part of each pixel that geometry covers.")
      .def_property_readonly(
          "emission", [](const api::Cache& cache) { return own_array(cache.emission()); },
          "(height, width, 3), what materials send out by themselves, whatever the lights.")
      .def_property_readonly(
          "predicted_error",
          [](const api::Cache& cache) { return own_array(cache.predicted_error()); },
          "(height, width), what reduction is predicted to have changed.");
}

void bind_relighter(py::module_& module) {
  py::class_<api::Relighter>(module, "Relighter", "One picture that follows its lights.")
      .def(py::init<const api::Cache&, const std::string&>(), py::arg("cache"),
           py::arg("shadow") = "ray", py::call_guard<py::gil_scoped_release>(),
           "shadow: none, ray, members, coverage, opacity, volume or auto.")
      .def("relight", &api::Relighter::relight, py::arg("lights"),
           py::call_guard<py::gil_scoped_release>(), "Brings the frame up to date.")
      .def_property_readonly(
          "frame",
          [](const py::object& self) {
            return view_array(self.cast<const api::Relighter&>().frame(), self);
          },
          "(height, width, 3), float32, scene-linear: a read-only view without a copy, which shows "
          "every later relight() too. Copy it to keep a frame.")
      .def(
          "layer",
          [](const api::Relighter& self, size_t light) { return own_array(self.layer(light)); },
          py::arg("light"),
          "What one light adds to the frame; layers and the cache's emission sum to it.")
      .def("save", &api::Relighter::save, py::arg("path"), py::call_guard<py::gil_scoped_release>(),
           "Writes .exr or .png.");
}

void bind_functions(py::module_& module) {
  py::class_<api::ImageError>(module, "ImageError", "How far an image is from a reference.")
      .def_readonly("error_image", &api::ImageError::error_image, "TR2007-600 eq. 7")
      .def_readonly("error_covered", &api::ImageError::error_covered)
      .def_readonly("rmse", &api::ImageError::rmse)
      .def_readonly("relative_mse", &api::ImageError::relative_mse)
      .def_readonly("max_error", &api::ImageError::max_error);
  module.def("prepare", &prepare, py::arg("scene"), py::arg("progress") = py::none(),
             "Samples and reduces a scene: a built-in label, a scene file or a glTF. Keywords are "
             "PrepareSettings' attributes. progress(stage, fraction) may return False to stop.");
  module.def("load", &api::Cache::open, py::arg("path"), "Opens a .relume file.");
  module.def(
      "compare",
      [](const InputArray& image, const InputArray& reference) {
        return api::compare(view_of(image), view_of(reference));
      },
      py::arg("image"), py::arg("reference"), "Compares two arrays (height, width, 3).");
  module.def(
      "read_image", [](const std::string& path) { return own_array(api::read_image(path)); },
      py::arg("path"), "RGB of an image file, scene-linear, (height, width, 3).");
  module.def("load_lights", &api::load_lights, py::arg("path"), "The lights of a light file.");
  module.def("save_lights", &api::save_lights, py::arg("path"), py::arg("lights"));
  module.def("set_threads", &api::set_threads, py::arg("threads"),
             "Threads that the process uses; 0: all. Call it first.");
}

}  // namespace

PYBIND11_MODULE(relume, module) {
  module.doc() = "Relume: relights final-quality pictures of hair and foliage.";
  module.attr("__version__") = api::version();
  py::register_exception<api::Error>(module, "Error", PyExc_RuntimeError);
  bind_light(module);
  bind_cache(module);
  bind_relighter(module);
  bind_functions(module);
}
