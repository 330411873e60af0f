// The names that users know things by.
#pragma once

#include <pybind11/pybind11.h>

namespace robsim::bindings {

/// The module, in which what is bound next says that it is of a public one, such as
/// "robsim.vision": help, signatures and errors show that name. Python exports it there.
inline pybind11::module_& public_in(pybind11::module_& module, const char* name) {
  module.attr("__module__") = name;
  return module;
}

}  // namespace robsim::bindings
