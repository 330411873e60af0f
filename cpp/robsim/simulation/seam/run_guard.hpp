#pragma once

#include <atomic>
#include <thread>

namespace robsim {

/// Lets one thread run the loop at a time.
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

  bool is_running() const { return running_; }

  /// Throws std::runtime_error while another thread runs the loop.
  void check_thread() const;

 private:
  std::atomic<bool> running_{false};
  std::atomic<std::thread::id> runner_{};
};

}  // namespace robsim
