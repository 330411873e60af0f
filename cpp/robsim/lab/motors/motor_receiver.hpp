#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "robsim/base/system.hpp"
#include "robsim/lab/motors/line.hpp"
#include "robsim/lab/motors/protocol.hpp"
#include "robsim/model/robot_model.hpp"

namespace robsim {

/// What a robot has received, and acts on, at any time.
class ReceivedInput {
 public:
  virtual ~ReceivedInput() = default;

  /// The mean of the input between two times (monotonic, s): 0 while it was stopped. From any
  /// thread.
  virtual Input mean(double from, double to) const = 0;
};

/// How many lines a robot has heard.
struct LineCounts {
  std::int64_t valid = 0;    // acted upon
  std::int64_t damaged = 0;  // or too long, or no line of the protocol
  std::int64_t old = 0;      // overtaken by a newer one
  std::int64_t foreign = 0;  // of another sender than the one it hears
};

/// The robot's end of a line, as PROTOCOL.md demands: it reads with a thread of its own. Any thread
/// may call any method. In a forked process all throw std::runtime_error.
class MotorReceiver : public ReceivedInput {
 public:
  /// What it hears, it acts upon `actuation_delay` (s) later. `answers`: to each valid line. Throws
  /// std::invalid_argument.
  MotorReceiver(Line line, double actuation_delay, bool answers);
  ~MotorReceiver() override;

  Input mean(double from, double to) const override;

  /// What it acts upon now.
  Input input() const;

  /// What it heard, and when it stopped by itself, at the time that it heard it.
  std::vector<MotorEvent> events() const;

  LineCounts counts() const;

  /// Hears no more: it stops when the time to live is over.
  void close();

  const std::string& name() const { return name_; }
  int port() const { return port_; }
  double actuation_delay() const { return actuation_delay_; }
  bool is_closed() const;  // true in a forked process

 private:
  struct State;

  std::string name_;
  int port_;
  double actuation_delay_;
  OfProcess<State> state_;
};

}  // namespace robsim
