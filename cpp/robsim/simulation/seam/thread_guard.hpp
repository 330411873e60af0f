#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <utility>

namespace robsim {

/// Says which thread has an object that changes: one for a run, or, in between, one after the other
/// for a look. A thread may claim what it has already.
class ThreadGuard {
 public:
  /// `in_use` is what other threads are told during a run, `lost` what a forked process is told
  /// whose parent was in the middle of one.
  ThreadGuard(std::string in_use, std::string lost)
      : in_use_(std::move(in_use)), lost_(std::move(lost)) {}
  ThreadGuard(const ThreadGuard&) = delete;
  ThreadGuard& operator=(const ThreadGuard&) = delete;

  /// True while a thread of this process has it for a run.
  bool is_in_run() const;

  /// Throws std::runtime_error while another thread has it for a run.
  void check_thread() const;

 protected:
  // Gives the object to this thread for its life, waits while another one looks at it. Throws
  // std::runtime_error while another one has it for a run.
  class Claim {
   public:
    Claim(const ThreadGuard& guard, bool is_run);
    ~Claim() { guard_.owner_ = before_; }
    Claim(const Claim&) = delete;
    Claim& operator=(const Claim&) = delete;

   private:
    const ThreadGuard& guard_;
    std::uint64_t before_ = 0;
  };

 public:
  class Run : public Claim {
   public:
    explicit Run(const ThreadGuard& guard) : Claim(guard, true) {}
  };

  class Look : public Claim {
   public:
    explicit Look(const ThreadGuard& guard) : Claim(guard, false) {}
  };

 private:
  void refuse(std::uint64_t owner) const;

  std::string in_use_, lost_;
  mutable std::atomic<std::uint64_t> owner_{0};  // 2 number of the thread + 1 in a run; 0 = none
};

}  // namespace robsim
