#pragma once

#include <atomic>
#include <mutex>
#include <thread>

namespace robsim {

/// Lets one thread run the loop at a time, and any thread ask it to stop.
class RunGuard {
 public:
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
  };

  /// Lets one thread look at what a run would change, for its life: the one that runs it, or any
  /// other while none does. A run that begins waits for it.
  class Look {
   public:
    /// Throws std::runtime_error while another thread runs the loop.
    explicit Look(const RunGuard& guard);

   private:
    std::unique_lock<std::recursive_mutex> lock_;
  };

  bool is_running() const { return state_ != State::idle; }

  /// Throws std::runtime_error that says what cannot be changed, if a run is under way.
  void check_idle(const char* what) const;

  /// Asks the run under way to end, and no later one; false if there is none.
  bool stop();

  /// True if the run under way was asked to end.
  bool is_stopped() const { return state_ == State::stopping; }

  /// Throws std::runtime_error while another thread runs the loop.
  void check_thread() const;

 private:
  enum class State { idle, running, stopping };

  std::atomic<State> state_{State::idle};
  std::atomic<std::thread::id> runner_{};
  mutable std::recursive_mutex looking_;
};

}  // namespace robsim
