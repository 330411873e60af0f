#pragma once

#include <Python.h>

namespace robsim::bindings {

/// True while the interpreter ends: no other thread gets it any more.
inline bool is_finalizing() {
#if PY_VERSION_HEX >= 0x030D0000
  return Py_IsFinalizing() != 0;
#else
  return _Py_IsFinalizing() != 0;
#endif
}

}  // namespace robsim::bindings
