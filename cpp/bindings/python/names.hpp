#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace robsim::bindings {

constexpr std::size_t longest_name = 40;  // characters, as in _base/checks.py

/// Returns a name that can be shown anywhere: in a table, in a terminal, as the head of a column.
/// `what` it is the name of, for the message.
inline std::string name_from(const pybind11::str& name, const std::string& what = "name") {
  namespace py = pybind11;
  if (py::len(name) - 1 < longest_name && name.attr("isprintable")().cast<bool>()) return name;
  const py::str start = name[py::slice(0, longest_name, 1)];
  throw py::value_error(what + " must be 1 to 40 printable characters, got " +
                        std::string(py::repr(start)) + (py::len(name) > longest_name ? "..." : ""));
}

}  // namespace robsim::bindings
