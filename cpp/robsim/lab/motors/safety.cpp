#include "robsim/lab/motors/safety.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include "robsim/base/system.hpp"

namespace robsim {

namespace {

double larger(const Input& u) { return std::max(std::abs(u.u1), std::abs(u.u2)); }

Input scaled(const Input& u, double limit) {
  if (larger(u) <= limit) return u;
  const double factor = limit / larger(u);
  // Rounding may lead out by the last digit.
  return {std::clamp(u.u1 * factor, -limit, limit), std::clamp(u.u2 * factor, -limit, limit)};
}

}  // namespace

void Limits::check() const {
  checked(voltage, voltage > 0, "voltage must be above 0 V");
  checked(slew_rate, slew_rate > 0, "slew_rate must be above 0 V/s");
}

Input Limits::applied(const Input& u, const Input& before, double dt) const {
  if (u.u1 == 0 && u.u2 == 0) return u;
  const Input wanted = scaled(u, voltage);
  if (std::isinf(slew_rate)) return wanted;
  const Input change = {wanted.u1 - before.u1, wanted.u2 - before.u2};
  const double most = slew_rate * std::max(dt, 0.0);
  if (larger(change) <= most) return wanted;
  const Input step = scaled(change, most);
  return {before.u1 + step.u1, before.u2 + step.u2};
}

struct Watchdog::State {
  explicit State(std::function<void()> expired) : on_expiry(std::move(expired)) {}
  ~State();

  void watch();
  bool is_watching_thread() const { return std::this_thread::get_id() == thread.get_id(); }

  const std::function<void()> on_expiry;
  std::atomic<double> timeout{0};   // s
  std::atomic<double> deadline{0};  // monotonic, s
  std::atomic<bool> has_expired{false};

  std::mutex mutex;  // guards what follows
  std::condition_variable changed;
  bool is_armed = false, is_calling = false, is_closing = false;
  std::thread thread;
};

Watchdog::State::~State() {
  {
    const std::lock_guard lock(mutex);
    is_closing = true;
  }
  changed.notify_all();
  if (thread.joinable()) thread.join();
}

// Feeding moves the deadline alone: the thread sleeps until the one it knows of, and looks again.
void Watchdog::State::watch() {
  constexpr double longest_sleep = 3600;  // s; inf is no time to wait for
  std::unique_lock lock(mutex);
  while (!is_closing) {
    if (!is_armed) {
      changed.wait(lock);
      continue;
    }
    const double left = deadline - monotonic_now();
    if (left > 0) {
      changed.wait_for(lock, std::chrono::duration<double>(std::min(left, longest_sleep)));
      continue;
    }
    is_armed = false;
    has_expired = true;
    is_calling = true;
    lock.unlock();
    on_expiry();
    lock.lock();
    is_calling = false;
    changed.notify_all();
  }
}

Watchdog::Watchdog(std::function<void()> on_expiry)
    : state_("the watchdog", std::move(on_expiry)) {}

Watchdog::~Watchdog() = default;

void Watchdog::arm(double timeout) {
  checked(timeout, timeout > 0, "timeout must be above 0 s");
  State& state = *state_.operator->();
  const std::lock_guard lock(state.mutex);
  if (!state.thread.joinable()) state.thread = start_thread([&state] { state.watch(); });
  state.timeout = timeout;
  state.deadline = monotonic_now() + timeout;
  state.has_expired = false;
  state.is_armed = true;
  state.changed.notify_all();
}

void Watchdog::set_timeout(double timeout) { state_.unchecked().timeout = timeout; }

void Watchdog::feed(double arrived) {
  State& state = state_.unchecked();
  const double deadline = std::min(arrived, monotonic_now()) + state.timeout;
  double before = state.deadline;
  while (before < deadline && !state.deadline.compare_exchange_weak(before, deadline)) {
  }
}

void Watchdog::disarm() {
  if (!state_.is_here()) return;
  State& state = state_.unchecked();
  std::unique_lock lock(state.mutex);
  state.is_armed = false;
  state.changed.notify_all();
  if (state.is_watching_thread()) return;
  state.changed.wait(lock, [&] { return !state.is_calling; });
}

bool Watchdog::has_expired() const { return state_.unchecked().has_expired; }

}  // namespace robsim
