#pragma once

#include <limits>

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

}  // namespace robsim
