#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <utility>

namespace robsim {

/// How to give up and take back what an interpreter around the core lets one thread hold at a time.
struct InterpreterLock {
  void* (*release)();      // null if this thread does not hold it
  void (*acquire)(void*);  // what release returned
};

/// Says how, once, when the core is loaded. Without it no interpreter is there.
void set_interpreter_lock(const InterpreterLock& lock);

/// Gives the interpreter up for its life, if this thread holds it: around long work that needs
/// none.
class NativeWork {
 public:
  NativeWork();

  /// The same around work on so many pixels, if that is long.
  explicit NativeWork(std::int64_t pixels);
  ~NativeWork();
  NativeWork(const NativeWork&) = delete;
  NativeWork& operator=(const NativeWork&) = delete;

 private:
  void* released_;
};

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

  /// Gives this thread, for its life, the run of another one, which waits meanwhile.
  class TakenOver {
   public:
    explicit TakenOver(const ThreadGuard& guard);
    ~TakenOver() { guard_.owner_ = before_; }
    TakenOver(const TakenOver&) = delete;
    TakenOver& operator=(const TakenOver&) = delete;

   private:
    const ThreadGuard& guard_;
    const std::uint64_t before_;
  };

 private:
  void refuse(std::uint64_t owner) const;

  std::string in_use_, lost_;
  mutable std::atomic<std::uint64_t> owner_{0};  // 2 number of the thread + 1 in a run; 0 = none
};

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
