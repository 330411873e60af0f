#include "robsim/simulation/seam/native_work.hpp"

namespace robsim {

namespace {
InterpreterLock interpreter_lock{[]() -> void* { return nullptr; }, [](void*) {}};

// Beside a busy thread it takes 5 ms to get the interpreter back. This many pixels are drawn, get
// their noise, or are searched for blobs within 0.1 ms.
constexpr std::int64_t few_pixels = 300 * 300;
}  // namespace

void set_interpreter_lock(const InterpreterLock& lock) { interpreter_lock = lock; }

NativeWork::NativeWork() : released_(interpreter_lock.release()) {}

NativeWork::NativeWork(std::int64_t pixels)
    : released_(pixels > few_pixels ? interpreter_lock.release() : nullptr) {}

NativeWork::~NativeWork() {
  if (released_) interpreter_lock.acquire(released_);
}

}  // namespace robsim
