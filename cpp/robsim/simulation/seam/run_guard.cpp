#include "robsim/simulation/seam/run_guard.hpp"

#include <stdexcept>
#include <string>

#include "robsim/simulation/seam/native_work.hpp"

namespace robsim {

RunGuard::Run::Run(RunGuard& guard) : guard_(guard) {
  State idle = State::idle;
  if (!guard_.state_.compare_exchange_strong(idle, State::running)) {
    throw std::runtime_error(
        "this simulation or experiment is already running: a callback or another thread cannot run "
        "it too");
  }
  guard_.runner_ = std::this_thread::get_id();
  // Whoever still looks may need the interpreter for it.
  const NativeWork native;
  const std::lock_guard<std::recursive_mutex> nobody_looks(guard_.looking_);
}

RunGuard::Run::~Run() { guard_.state_ = State::idle; }

bool RunGuard::stop() {
  State running = State::running;
  return state_.compare_exchange_strong(running, State::stopping) || running == State::stopping;
}

RunGuard::Look::Look(const RunGuard& guard) {
  guard.check_thread();
  if (guard.is_running()) return;  // by this thread
  {
    const NativeWork native;
    lock_ = std::unique_lock<std::recursive_mutex>(guard.looking_);
  }
  guard.check_thread();  // a run may have begun
}

void RunGuard::check_idle(const char* what) const {
  if (is_running()) {
    throw std::runtime_error(std::string(what) + " cannot be changed during a run");
  }
}

void RunGuard::check_thread() const {
  if (is_running() && runner_.load() != std::this_thread::get_id()) {
    throw std::runtime_error(
        "another thread is running this simulation or experiment: wait until it has finished");
  }
}

}  // namespace robsim
