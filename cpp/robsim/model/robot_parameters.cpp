#include "robsim/model/robot_parameters.hpp"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace robsim {

namespace {

[[noreturn]] void refuse(const char* name, const char* expected, double value, const char* why) {
  std::ostringstream message;
  message << name << " must be " << expected << ", got " << value << ": " << why;
  throw std::invalid_argument(message.str());
}

void check_positive(const char* name, double value, const char* why) {
  if (!(std::isfinite(value) && value > 0)) refuse(name, "positive and finite", value, why);
}

void check_friction(const char* name, double value) {
  if (!(std::isfinite(value) && value >= 0)) {
    refuse(name, "at least 0 and finite", value, "friction cannot drive the robot");
  }
}

void check_finite(const char* name, const std::array<double, 2>& values) {
  for (const double value : values) {
    if (!std::isfinite(value)) refuse(name, "finite", value, "a motor needs a torque");
  }
}

}  // namespace

void check_parameters(const RobotParameters& p) {
  check_positive("mass", p.mass, "a body has a mass (kg)");
  check_positive("inertia", p.inertia, "a body has a moment of inertia (kg m^2)");
  check_positive("wheel_radius", p.wheel_radius, "a wheel has a radius (m)");
  check_positive("wheel_base", p.wheel_base, "the wheels stand apart (m)");
  check_positive("dt", p.dt, "time goes on from step to step (s)");
  check_friction("linear_friction", p.linear_friction);
  check_friction("angular_friction", p.angular_friction);
  check_finite("motor_gain", p.motor_gain);
  check_finite("motor_offset", p.motor_offset);
}

}  // namespace robsim
