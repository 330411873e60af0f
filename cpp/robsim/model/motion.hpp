#pragma once

#include <Eigen/Core>
#include <vector>

#include "robsim/model/robot_model.hpp"

namespace robsim {

using Path = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Inputs = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// Derivatives of a pose of a simulated path: by the first two values of x, of y and of the
/// heading, and by the 15 parameters.
using PathDerivatives = Eigen::Matrix<double, 3, 21, Eigen::RowMajor>;

/// The path of the predictor with any parameters, from its first two poses and an input for each
/// step, of which there are at least two. Headings are not wrapped. Diverges without an error.
Path simulated_path(const AxisMatrix& theta,
                    const Eigen::Matrix<double, 2, 3, Eigen::RowMajor>& first,
                    const Eigen::Ref<const Inputs>& u);

/// The derivatives of each pose of a path that was simulated with these parameters and inputs.
std::vector<PathDerivatives> path_sensitivities(const AxisMatrix& theta,
                                                const Eigen::Ref<const Path>& path,
                                                const Eigen::Ref<const Inputs>& u);

/// The robot on wheels that do not slip sideways: it drives where it is headed.
/// Along a straight line, and in its heading, it moves as the RobotModel does.
struct Unicycle {
  /// The pose of step k from those of steps k-1 and k-2 and the input of step k-1.
  Pose operator()(const RobotModel& model, const Pose& pose_1, const Pose& pose_2,
                  const Input& u) const;
};

}  // namespace robsim
