#include "robsim/simulation/seam/thread_guard.hpp"

#include <chrono>
#include <stdexcept>
#include <thread>

#ifndef _WIN32
#include <pthread.h>
#endif

#include "robsim/simulation/seam/native_work.hpp"

namespace robsim {

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

}  // namespace robsim
