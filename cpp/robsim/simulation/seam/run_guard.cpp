#include "robsim/simulation/seam/run_guard.hpp"

#include <stdexcept>

namespace robsim {

RunGuard::Run::Run(RunGuard& guard) : guard_(guard) {
  if (guard_.running_.exchange(true)) {
    throw std::runtime_error(
        "this simulation is already running: a callback or another thread cannot run it too");
  }
  guard_.runner_ = std::this_thread::get_id();
}

RunGuard::Run::~Run() { guard_.running_ = false; }

void RunGuard::check_thread() const {
  if (running_ && runner_.load() != std::this_thread::get_id()) {
    throw std::runtime_error(
        "another thread is running this simulation: wait until it has finished");
  }
}

}  // namespace robsim
