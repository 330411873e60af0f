#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "robsim/model/robot_model.hpp"

namespace robsim {

/// What moves the robot beside its model: normal noise on the pose, and on what the motors get.
struct Disturbance {
  Eigen::Matrix3d pose_factor = Eigen::Matrix3d::Zero();  // L, covariance of a step = L L'
  std::array<double, 2> input_sigma = {0, 0};             // V
  bool is_on = false;                                     // one of them is not 0
  std::uint64_t seed = 0;

  /// What the motors get in step k in place of u.
  Input disturbed(const Input& u, std::int64_t k) const;

  /// Where the robot is in step k in place of the pose.
  Pose disturbed(const Pose& pose, std::int64_t k) const;
};

}  // namespace robsim
