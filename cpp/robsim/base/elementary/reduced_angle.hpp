#pragma once

#include "robsim/base/elementary/double_double.hpp"

namespace robsim::elementary {

/// An angle less the nearest multiple of pi/2.
struct ReducedAngle {
  DoubleDouble rest;  // within +-pi/4, but for rounding
  int quadrant = 0;   // the multiple, modulo 4
};

/// The angle (rad), any finite number, reduced with a relative error of less than 2^-63.
ReducedAngle reduced(double angle);

}  // namespace robsim::elementary
