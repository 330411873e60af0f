#pragma once

#include "robsim/model/robot_model.hpp"

namespace robsim {

/// The robot on wheels that do not slip sideways: it drives where it is headed.
/// Along a straight line, and in its heading, it moves as the RobotModel does.
struct Unicycle {
  /// The pose of step k from those of steps k-1 and k-2 and the input of step k-1.
  Pose operator()(const RobotModel& model, const Pose& pose_1, const Pose& pose_2,
                  const Input& u) const;
};

}  // namespace robsim
