#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include "robsim/model/robot_model.hpp"

namespace robsim {

/// What went over a line, or what a robot did by itself.
struct MotorEvent {
  enum class Kind {
    input,    // a new one
    repeat,   // the same once more, so that the robot goes on
    stop,     // it was told to
    failure,  // a line that could not be written
    timeout,  // the robot stopped by itself: it had heard nothing for the time to live
  };

  double t = 0;  // monotonic, s
  Input u;
  Kind kind = Kind::input;
};

/// The newest events.
class EventLog {
 public:
  void add(const MotorEvent& event) {
    if (events_.size() == most) events_.pop_front();
    events_.push_back(event);
  }

  std::vector<MotorEvent> get() const { return {events_.begin(), events_.end()}; }

 private:
  static constexpr std::size_t most = 100'000;
  std::deque<MotorEvent> events_;
};

}  // namespace robsim
