// The names that users know things by.
#pragma once

#include "python/signature.hpp"

namespace robsim::bindings {

/// The module, in which what is bound next says that it is of a public one, such as
/// "robsim.vision": help, signatures and errors show that name. Python exports it there.
inline Module public_in(py::module_& module, const char* name) {
  module.attr("__module__") = name;
  return Module(module);
}

}  // namespace robsim::bindings
