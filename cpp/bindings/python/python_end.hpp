// Included before all else in every binding: see CMakeLists.txt.
//
// When Python ends, it tears a daemon thread that wants the interpreter out of all calls, before
// 3.14: by an exception that passes through destructors that need it, or abort. Here such a thread
// waits for the end of the program instead, as from 3.14 on: in our code, and in pybind11's.
#pragma once

#include <Python.h>

#include <chrono>
#include <thread>

namespace robsim::bindings {

[[noreturn]] inline void wait_for_the_end() noexcept {
  while (true) std::this_thread::sleep_for(std::chrono::hours(1));
}

/// Calls a function in C, which throws nothing unless Python ends.
template <typename Call>
decltype(auto) unless_python_ends(const Call& call) noexcept {
  try {
    return call();
  } catch (...) {
    wait_for_the_end();
  }
}

}  // namespace robsim::bindings

#define ROBSIM_UNLESS_PYTHON_ENDS(call) \
  ::robsim::bindings::unless_python_ends([&]() -> decltype(auto) { return call; })
#define PyEval_AcquireThread(...) ROBSIM_UNLESS_PYTHON_ENDS(PyEval_AcquireThread(__VA_ARGS__))
#define PyEval_RestoreThread(...) ROBSIM_UNLESS_PYTHON_ENDS(PyEval_RestoreThread(__VA_ARGS__))
#define PyErr_CheckSignals(...) ROBSIM_UNLESS_PYTHON_ENDS(PyErr_CheckSignals(__VA_ARGS__))
#define PyGILState_Ensure(...) ROBSIM_UNLESS_PYTHON_ENDS(PyGILState_Ensure(__VA_ARGS__))
#define PyImport_ImportModule(...) ROBSIM_UNLESS_PYTHON_ENDS(PyImport_ImportModule(__VA_ARGS__))
#define PyObject_Call(...) ROBSIM_UNLESS_PYTHON_ENDS(PyObject_Call(__VA_ARGS__))
#define PyObject_CallObject(...) ROBSIM_UNLESS_PYTHON_ENDS(PyObject_CallObject(__VA_ARGS__))
#define PyObject_GetAttr(...) ROBSIM_UNLESS_PYTHON_ENDS(PyObject_GetAttr(__VA_ARGS__))
#define PyObject_GetAttrString(...) ROBSIM_UNLESS_PYTHON_ENDS(PyObject_GetAttrString(__VA_ARGS__))
#define PyObject_Repr(...) ROBSIM_UNLESS_PYTHON_ENDS(PyObject_Repr(__VA_ARGS__))
#define PyObject_Str(...) ROBSIM_UNLESS_PYTHON_ENDS(PyObject_Str(__VA_ARGS__))
#define PyObject_Vectorcall(...) ROBSIM_UNLESS_PYTHON_ENDS(PyObject_Vectorcall(__VA_ARGS__))
