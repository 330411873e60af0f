#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "robsim/base/system.hpp"
#include "robsim/lab/motors/line.hpp"
#include "robsim/lab/motors/protocol.hpp"

namespace robsim {

/// An input was refused, since the robot was stopped for good.
class HaltedError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The sender's end of a line to a robot. Its thread repeats the newest input, and stops the robot
/// when none has come for some time; it needs no interpreter. Any thread may call any method. In a
/// forked process all throw std::runtime_error.
class MotorLink {
 public:
  /// The robot stops by itself when it hears nothing for `time_to_live` (s); the link stops it when
  /// no input was sent for `hold` (s). Throws std::invalid_argument.
  MotorLink(Line line, double time_to_live, double hold);

  /// As `close`, but throws nothing.
  ~MotorLink();

  /// Sends an input (V) and returns when it was written: monotonic, s. Throws LineError for an
  /// error of the line since the last input, or now, HaltedError, and std::invalid_argument.
  double send(const Input& u);

  /// Stops the robot, and tells it so several times more. Returns and throws as `send`; what failed
  /// is tried again.
  double stop();

  /// As `stop`, for the end of a run: throws nothing, `check_stop` does later. False in a forked
  /// process, whose robot it is not.
  bool stop_quietly() noexcept;

  /// Throws LineError, once, if the last stop did not get into the line.
  void check_stop();

  /// Stops the robot and refuses inputs from now on: for a watchdog.
  void halt() noexcept;

  /// Takes inputs again.
  void resume();

  /// Stops the robot and ends. Throws LineError if the robot could not be told to stop.
  void close();

  const std::string& name() const { return name_; }
  double time_to_live() const { return time_to_live_; }
  double hold() const { return hold_; }
  bool is_halted() const;
  bool is_closed() const;  // true in a forked process

  /// What was sent.
  std::vector<MotorEvent> events() const;

  /// How long answers took, the newest ones (s). Empty: the robot does not answer.
  std::vector<double> round_trip_times() const;

  /// Whether lines go out, and the robot, which answered before, has answered none for a second.
  bool is_silent() const;

 private:
  struct State;

  std::string name_;
  double time_to_live_, hold_;
  OfProcess<State> state_;
};

}  // namespace robsim
