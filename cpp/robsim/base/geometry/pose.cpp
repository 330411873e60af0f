#include "robsim/base/geometry/pose.hpp"

#include <cmath>

namespace robsim {

double wrap_angle(double angle) {
  if (angle > -pi && angle <= pi) return angle;  // the common case; remainder() is slow
  const double wrapped = std::remainder(angle, 2 * pi);
  return wrapped <= -pi ? pi : wrapped;
}

bool is_finite(const Pose& pose) {
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.heading);
}

}  // namespace robsim
