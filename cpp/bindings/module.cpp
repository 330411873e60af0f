// The table of contents of the extension: one function per room, several for vision and simulation.
#include <pybind11/pybind11.h>

namespace py = pybind11;

void bind_simd(py::module_& module);
void bind_geometry(py::module_& module);
void bind_imaging(py::module_& module);
void bind_model(py::module_& module);
void bind_world(py::module_& module);
void bind_color(py::module_& module);
void bind_blobs(py::module_& module);
void bind_locate(py::module_& module);
void bind_estimation(py::module_& module);
void bind_records(py::module_& module);
void bind_steps(py::module_& module);
void bind_worlds(py::module_& module);
void bind_controllers(py::module_& module);
void bind_trace(py::module_& module);
void bind_loop(py::module_& module);

PYBIND11_MODULE(_core, module) {
  module.doc() = "The C++ core of robsim. What users need of it is re-exported by robsim.";
  bind_simd(module);
  bind_geometry(module);
  bind_imaging(module);
  bind_model(module);
  bind_world(module);
  bind_color(module);
  bind_blobs(module);
  bind_locate(module);
  bind_estimation(module);
  bind_trace(module);
  bind_records(module);
  bind_steps(module);
  bind_worlds(module);
  bind_controllers(module);
  bind_loop(module);
  pybind11::delattr(module, "__module__");  // the bindings set it
}
