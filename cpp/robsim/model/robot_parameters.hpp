#pragma once

#include <array>

namespace robsim {

/// The physical robot. The defaults reproduce the true values printed in the manual of 2008.
struct RobotParameters {
  double mass = 0.3;                                  // kg
  double inertia = 0.1;                               // kg m^2
  double linear_friction = 0.1;                       // viscous, N s/m
  double angular_friction = 0.1;                      // viscous, N m s/rad
  double wheel_radius = 0.03;                         // m
  double wheel_base = 0.11;                           // m
  std::array<double, 2> motor_gain = {0.05, 0.05};    // torque per voltage, left and right, N m/V
  std::array<double, 2> motor_offset = {1e-6, 1e-6};  // torque at 0 V, left and right, N m
  double dt = 0.2;                                    // sample time, s
};

/// Throws std::invalid_argument that names the value that is not physical, and why.
void check_parameters(const RobotParameters& parameters);

}  // namespace robsim
