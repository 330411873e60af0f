#include "robsim/simulation/seam/thread_guard.hpp"

#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>

#ifndef _WIN32
#include <pthread.h>
#endif

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

namespace {

std::atomic<std::uint64_t> next_number{1};

// Numbers of threads, since the system uses its ids again: in a forked process, too.
std::uint64_t this_thread() {
  thread_local const std::uint64_t number = next_number++;
  return number;
}

// A fork leaves a process with one thread of its parent's.
std::atomic<std::uint64_t> first_here{0};
std::atomic<std::uint64_t> forking{0};

#ifndef _WIN32
[[maybe_unused]] const int watches_forks = pthread_atfork(nullptr, nullptr, [] {
  forking = this_thread();
  first_here = next_number.load();
});
#endif

bool is_lost(std::uint64_t thread) { return thread < first_here && thread != forking; }

constexpr bool is_run(std::uint64_t owner) { return owner % 2 == 1; }
constexpr std::uint64_t thread_of(std::uint64_t owner) { return owner / 2; }

}  // namespace

ThreadGuard::Claim::Claim(const ThreadGuard& guard, bool for_run) : guard_(guard) {
  const std::uint64_t claim = 2 * this_thread() + (for_run ? 1 : 0);
  while (!guard.owner_.compare_exchange_strong(before_, claim)) {
    if (thread_of(before_) == this_thread()) {
      guard.owner_ = claim | before_;
      return;
    }
    guard.refuse(before_);
    before_ = 0;
    // Whoever still looks may need the interpreter.
    const NativeWork native;
    std::this_thread::sleep_for(std::chrono::microseconds(50));
  }
}

ThreadGuard::TakenOver::TakenOver(const ThreadGuard& guard)
    : guard_(guard), before_(guard.owner_.exchange(2 * this_thread() + 1)) {}

bool ThreadGuard::is_in_run() const {
  const std::uint64_t owner = owner_;
  return is_run(owner) && !is_lost(thread_of(owner));
}

void ThreadGuard::check_thread() const {
  const std::uint64_t owner = owner_;
  if (thread_of(owner) != this_thread()) refuse(owner);
}

void ThreadGuard::refuse(std::uint64_t owner) const {
  if (owner == 0) return;
  if (is_lost(thread_of(owner))) throw std::runtime_error(lost_);
  if (is_run(owner)) throw std::runtime_error(in_use_);
}

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
