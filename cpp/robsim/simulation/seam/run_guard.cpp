#include "robsim/simulation/seam/run_guard.hpp"

#include <stdexcept>
#include <string>

namespace robsim {

RunGuard::RunGuard()
    : ThreadGuard(
          "another thread is running this simulation or experiment: wait until it has finished; "
          "its trace, n_steps and stage can be read meanwhile; a callback that starts threads of "
          "its own reads for them what they need of step",
          "another thread was running this simulation or experiment when the process was forked, "
          "and only half of a step is here: make another one in this process") {}

RunGuard::Run::Run(RunGuard& guard) : guard_(guard), run_(guard.checked_idle()) {
  guard_.state_ = State::running;
}

RunGuard::Run::~Run() { guard_.state_ = State::idle; }

const RunGuard& RunGuard::checked_idle() const {
  if (!is_running()) return *this;
  throw std::runtime_error(
      "this simulation or experiment is already running: a callback or another thread cannot run "
      "it too");
}

bool RunGuard::stop() {
  if (!is_running()) return false;  // in a forked process
  State running = State::running;
  return state_.compare_exchange_strong(running, State::stopping) || running == State::stopping;
}

void RunGuard::check_idle(const char* what) const {
  if (is_running()) {
    throw std::runtime_error(std::string(what) + " cannot be changed during a run");
  }
}

}  // namespace robsim
