#pragma once

#include <pybind11/pybind11.h>

#include "capture/device_text.hpp"
#include "robsim/lab/capture/capture_device.hpp"

namespace robsim::bindings {

/// Raises the error of robsim.lab that a fault stands for.
inline void raise_in_python(const CaptureError& error) {
  namespace py = pybind11;
  const py::object raised =
      py::module_::import("robsim.lab.cameras.errors")
          .attr("error_of")(name_of(error.fault()), device_text(error.what()));
  PyErr_SetObject(py::type::handle_of(raised).ptr(), raised.ptr());
}

/// Lets the functions of this extension raise what they throw as a CaptureError.
inline void translate_capture_errors() {
  namespace py = pybind11;
  py::register_local_exception_translator([](std::exception_ptr error) {
    try {
      std::rethrow_exception(error);
    } catch (const CaptureError& fault) {
      try {
        raise_in_python(fault);
      } catch (py::error_already_set& failed) {
        failed.restore();
      }
    }
  });
}

}  // namespace robsim::bindings
