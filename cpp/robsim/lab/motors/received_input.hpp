#pragma once

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

}  // namespace robsim
