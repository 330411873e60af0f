#include "robsim/simulation/seam/run_guard.hpp"

#include <stdexcept>

namespace robsim {

RunGuard::Run::Run(RunGuard& guard) : guard_(guard) {
  State idle = State::idle;
  if (!guard_.state_.compare_exchange_strong(idle, State::running)) {
    throw std::runtime_error(
        "this simulation is already running: a callback or another thread cannot run it too");
  }
  guard_.runner_ = std::this_thread::get_id();
}

RunGuard::Run::~Run() { guard_.state_ = State::idle; }

bool RunGuard::stop() {
  State running = State::running;
  return state_.compare_exchange_strong(running, State::stopping) || running == State::stopping;
}

void RunGuard::check_thread() const {
  if (is_running() && runner_.load() != std::this_thread::get_id()) {
    throw std::runtime_error(
        "another thread is running this simulation: wait until it has finished");
  }
}

}  // namespace robsim
