#pragma once

#include <memory>
#include <utility>

#include "python/python_end.hpp"

namespace robsim::bindings {

/// Gives up the interpreter, which this thread holds, for its life.
class WithoutInterpreter {
 public:
  WithoutInterpreter() : state_(PyEval_SaveThread()) {}
  ~WithoutInterpreter() { PyEval_RestoreThread(state_); }
  WithoutInterpreter(const WithoutInterpreter&) = delete;
  WithoutInterpreter& operator=(const WithoutInterpreter&) = delete;

 private:
  PyThreadState* state_;
};

/// The result of work that needs no interpreter.
template <typename Work>
auto natively(const Work& work) {
  const WithoutInterpreter others;
  return work();
}

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
