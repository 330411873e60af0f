#pragma once

#include <functional>
#include <limits>

#include "robsim/base/system.hpp"
#include "robsim/model/robot_model.hpp"

namespace robsim {

/// What a robot's motors are asked for at most.
struct Limits {
  double voltage = std::numeric_limits<double>::infinity();    // of a motor, V
  double slew_rate = std::numeric_limits<double>::infinity();  // of a motor, V/s

  /// Throws std::invalid_argument unless both are above 0.
  void check() const;

  /// The input within the limits, a time `dt` (s) after `before`. Both motors are scaled by one
  /// factor, so that the robot drives the same curve, more slowly. An input of 0, 0 stops at once.
  Input applied(const Input& u, const Input& before, double dt) const;
};

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

  /// Another time-out (s), from the next call of `feed` on.
  void set_timeout(double timeout);

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
