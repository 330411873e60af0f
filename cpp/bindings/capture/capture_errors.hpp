#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "robsim/lab/capture/capture_device.hpp"

namespace robsim::bindings {

/// Text of a device, which may be in any coding, or cut: invalid UTF-8 becomes U+FFFD.
inline pybind11::str device_text(const std::string& text) {
  PyObject* const decoded =
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "replace");
  if (!decoded) throw pybind11::error_already_set();
  return pybind11::reinterpret_steal<pybind11::str>(decoded);
}

/// Raises the error of robsim.lab that a fault stands for.
inline void raise_in_python(const CaptureError& error) {
  namespace py = pybind11;
  const py::object raised =
      py::module_::import("robsim.lab.cameras.errors")
          .attr("error_of")(name_of(error.fault()), device_text(error.what()));
  PyErr_SetObject(py::type::handle_of(raised).ptr(), raised.ptr());
}

/// Lets the functions of this extension raise their exceptions as a CaptureError.
template <void (*raise)(const CaptureError&) = &raise_in_python>
void translate_capture_errors() {
  pybind11::register_local_exception_translator([](std::exception_ptr error) {
    try {
      std::rethrow_exception(error);
    } catch (const CaptureError& fault) {
      raise(fault);
    }
  });
}

}  // namespace robsim::bindings
