// The table of contents of the extension: one function per room, several for vision and simulation.
#include <pybind11/pybind11.h>

#include <new>

#include "robsim/simulation/world/external_world.hpp"

namespace py = pybind11;

using Binding = void(py::module_& module);
Binding bind_base, bind_plane_maps, bind_imaging, bind_capture, bind_model, bind_scene, bind_color,
    bind_markers, bind_blobs, bind_locate, bind_estimation, bind_trace, bind_records, bind_steps,
    bind_motors, bind_simulated_worlds, bind_controllers, bind_remote, bind_loop, bind_laboratory;

namespace {

const char* const in_sub_interpreter =
    "robsim cannot be imported in a sub-interpreter: it works in the main interpreter of a process "
    "alone. Import it there, or in a separate process (multiprocessing, subprocess)";

bool is_main_interpreter() { return PyInterpreterState_Get() == PyInterpreterState_Main(); }

// Better messages than the default ones: "std::bad_alloc", RuntimeError.
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
  module.doc() = "The C++ core of robsim. robsim re-exports its public part.";
  translate_errors();
  // A class comes before the signatures that show it.
  for (Binding* bind : {bind_base,        bind_plane_maps, bind_imaging,    bind_capture,
                        bind_model,       bind_scene,      bind_color,      bind_markers,
                        bind_blobs,       bind_locate,     bind_estimation, bind_trace,
                        bind_records,     bind_steps,      bind_motors,     bind_simulated_worlds,
                        bind_controllers, bind_remote,     bind_loop,       bind_laboratory}) {
    bind(module);
  }
  pybind11::delattr(module, "__module__");  // the bindings set it
}

// In a sub-interpreter pybind11 may wait endlessly for the lock of the main one: so the module's
// own entry looks first. From Python 3.13 on it is called in the main one for all: the body looks
// again.
extern "C" PYBIND11_EXPORT PyObject* PyInit__core() {
  if (is_main_interpreter()) return PyInit_core_of_the_main_interpreter();
  PyErr_SetString(PyExc_ImportError, in_sub_interpreter);
  return nullptr;
}
