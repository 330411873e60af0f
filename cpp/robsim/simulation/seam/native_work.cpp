#include "robsim/simulation/seam/native_work.hpp"

namespace robsim {

namespace {
InterpreterLock interpreter_lock{[]() -> void* { return nullptr; }, [](void*) {}};
}  // namespace

void set_interpreter_lock(const InterpreterLock& lock) { interpreter_lock = lock; }

NativeWork::NativeWork() : released_(interpreter_lock.release()) {}

NativeWork::~NativeWork() {
  if (released_) interpreter_lock.acquire(released_);
}

}  // namespace robsim
