#pragma once

#include <atomic>

#include "robsim/simulation/seam/thread_guard.hpp"

namespace robsim {

/// Lets one thread run the loop at a time, and any thread ask it to stop.
class RunGuard : public ThreadGuard {
 public:
  RunGuard();

  /// Marks the loop as running for its life.
  class Run {
   public:
    /// Throws std::runtime_error if it is running already.
    explicit Run(RunGuard& guard);
    ~Run();
    Run(const Run&) = delete;
    Run& operator=(const Run&) = delete;

   private:
    RunGuard& guard_;
    ThreadGuard::Run run_;
  };

  bool is_running() const { return is_in_run(); }

  /// Throws std::runtime_error that says what cannot be changed, if a run is under way.
  void check_idle(const char* what) const;

  /// Asks the run under way to end, and no later one; false if there is none.
  bool stop();

  /// True if the run under way was asked to end.
  bool is_stopped() const { return state_ == State::stopping; }

 private:
  enum class State { idle, running, stopping };

  const RunGuard& checked_idle() const;

  std::atomic<State> state_{State::idle};
};

}  // namespace robsim
