#pragma once

#include <cstdint>

namespace robsim {

/// How to give up and take back what an interpreter around the core lets one thread hold at a time.
struct InterpreterLock {
  void* (*release)();      // null if this thread does not hold it
  void (*acquire)(void*);  // what release returned
};

/// Says how, once, when the core is loaded. Without it no interpreter is there.
void set_interpreter_lock(const InterpreterLock& lock);

/// Gives the interpreter up for its life, if this thread holds it: around long work that needs
/// none.
class NativeWork {
 public:
  NativeWork();

  /// The same around work on so many pixels, if that is long.
  explicit NativeWork(std::int64_t pixels);
  ~NativeWork();
  NativeWork(const NativeWork&) = delete;
  NativeWork& operator=(const NativeWork&) = delete;

 private:
  void* released_;
};

}  // namespace robsim
