#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace robsim::bindings {

/// Text of a device, which may be in any coding, or cut: what is no UTF-8 becomes U+FFFD.
inline pybind11::str device_text(const std::string& text) {
  PyObject* const decoded =
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "replace");
  if (!decoded) throw pybind11::error_already_set();
  return pybind11::reinterpret_steal<pybind11::str>(decoded);
}

}  // namespace robsim::bindings
