#pragma once

#include <Python.h>

#include <chrono>
#include <memory>
#include <thread>
#include <utility>

namespace robsim::bindings {

/// True while the interpreter ends: no other thread gets it any more.
inline bool is_finalizing() {
#if PY_VERSION_HEX >= 0x030D0000
  return Py_IsFinalizing() != 0;
#else
  return _Py_IsFinalizing() != 0;
#endif
}

/// Waits for the end of the program. When Python ends, it tears a daemon thread that comes back to
/// it out of all calls, by an exception that nobody may swallow: a destructor on its way would
/// abort.
[[noreturn]] inline void wait_for_the_end() noexcept {
  while (true) std::this_thread::sleep_for(std::chrono::hours(1));
}

/// As PyEval_RestoreThread, but for the end of Python.
inline void take_interpreter_back(PyThreadState* state) noexcept {
  try {
    PyEval_RestoreThread(state);
  } catch (...) {
    wait_for_the_end();
  }
}

/// Gives up the interpreter, which this thread holds, for its life.
class WithoutInterpreter {
 public:
  WithoutInterpreter() : state_(PyEval_SaveThread()) {}
  ~WithoutInterpreter() { take_interpreter_back(state_); }
  WithoutInterpreter(const WithoutInterpreter&) = delete;
  WithoutInterpreter& operator=(const WithoutInterpreter&) = delete;

 private:
  PyThreadState* state_;
};

/// An object whose end waits for its thread, and gives up the interpreter meanwhile.
template <typename T, typename... A>
std::shared_ptr<T> make_native(A&&... arguments) {
  return std::shared_ptr<T>(new T(std::forward<A>(arguments)...), [](const T* value) {
    if (!PyGILState_Check()) {
      delete value;
      return;
    }
    const WithoutInterpreter others;
    delete value;
  });
}

}  // namespace robsim::bindings
