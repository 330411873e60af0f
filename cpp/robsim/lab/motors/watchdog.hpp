#pragma once

#include <functional>

#include "robsim/base/system.hpp"

namespace robsim {

/// Calls a function when nobody has fed it in time: with a thread of its own, which needs no
/// interpreter. Any thread may call any method.
class Watchdog {
 public:
  /// `on_expiry` must not throw; it may call the watchdog.
  explicit Watchdog(std::function<void()> on_expiry);
  ~Watchdog();

  /// From now on it watches, and expires if it is not fed within `timeout` (s, above 0, inf =
  /// never). Throws std::invalid_argument, and std::runtime_error in a forked process.
  void arm(double timeout);

  /// What was waited for arrived at this time (monotonic, s): the next is due one time-out later. A
  /// time in the future counts as now. Costs no system call.
  void feed(double arrived);

  /// Watches no more. When it returns, `on_expiry` is not being called, nor will it be.
  void disarm();

  /// Whether it has expired since it was armed.
  bool has_expired() const;

 private:
  struct State;
  OfProcess<State> state_;
};

}  // namespace robsim
