// The table of contents of the extension: one function per room, several for vision and simulation.
#include <pybind11/pybind11.h>

#include <new>

#include "robsim/simulation/world/external_world.hpp"

namespace py = pybind11;

void bind_base(py::module_& module);
void bind_plane_maps(py::module_& module);
void bind_imaging(py::module_& module);
void bind_capture(py::module_& module);
void bind_model(py::module_& module);
void bind_world(py::module_& module);
void bind_color(py::module_& module);
void bind_markers(py::module_& module);
void bind_blobs(py::module_& module);
void bind_locate(py::module_& module);
void bind_estimation(py::module_& module);
void bind_records(py::module_& module);
void bind_steps(py::module_& module);
void bind_worlds(py::module_& module);
void bind_controllers(py::module_& module);
void bind_remote(py::module_& module);
void bind_trace(py::module_& module);
void bind_loop(py::module_& module);
void bind_motors(py::module_& module);
void bind_laboratory(py::module_& module);

namespace {

const char* const in_sub_interpreter =
    "robsim cannot be imported in a sub-interpreter: it works in the main interpreter of a process "
    "alone. Import it there, or in a process of its own (multiprocessing, subprocess)";

bool is_main_interpreter() { return PyInterpreterState_Get() == PyInterpreterState_Main(); }

// What the default would say less well: "std::bad_alloc", RuntimeError.
void translate_errors() {
  py::register_local_exception_translator([](std::exception_ptr error) {
    try {
      std::rethrow_exception(error);
    } catch (const robsim::FrameTimeout& timeout) {
      PyErr_SetString(PyExc_TimeoutError, timeout.what());
    } catch (const std::bad_alloc&) {
      PyErr_SetString(PyExc_MemoryError,
                      "there is not enough memory: fewer steps, a smaller area or a smaller "
                      "resolution of the camera need less");
    }
  });
}

}  // namespace

PYBIND11_MODULE(core_of_the_main_interpreter, module, py::multiple_interpreters::not_supported()) {
  if (!is_main_interpreter()) throw py::import_error(in_sub_interpreter);
  module.doc() = "The C++ core of robsim. What users need of it is re-exported by robsim.";
  translate_errors();
  bind_base(module);
  bind_plane_maps(module);
  bind_imaging(module);
  bind_capture(module);
  bind_model(module);
  bind_world(module);
  bind_color(module);
  bind_markers(module);
  bind_blobs(module);
  bind_locate(module);
  bind_estimation(module);
  bind_trace(module);
  bind_records(module);
  bind_steps(module);
  bind_motors(module);
  bind_worlds(module);
  bind_controllers(module);
  bind_remote(module);
  bind_loop(module);
  bind_laboratory(module);
  pybind11::delattr(module, "__module__");  // the bindings set it
}

// In a sub-interpreter pybind11 may wait for ever for the lock of the main one: so the module's own
// entry looks first. From Python 3.13 on it is called in the main one for all: the body looks
// again.
extern "C" PYBIND11_EXPORT PyObject* PyInit__core() {
  if (is_main_interpreter()) return PyInit_core_of_the_main_interpreter();
  PyErr_SetString(PyExc_ImportError, in_sub_interpreter);
  return nullptr;
}
