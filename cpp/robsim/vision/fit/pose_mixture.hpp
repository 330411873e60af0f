#pragma once

#include <vector>

#include "robsim/vision/fit/pose_fit.hpp"

namespace robsim::fit {

/// A pose that may be the true one: `shift` from the fitted pose (px, px, rad).
struct PossiblePose {
  double odds;
  Eigen::Vector3d shift;
  PoseCovariance covariance;
};

/// The shift from a fit to the pose `to`.
Eigen::Vector3d shift_between(const Pose& from, const Pose& to);

/// Makes a fit the mean of the poses that are possible, with the covariance of their mixture. Its
/// misfit grows as the variance that grows most.
/// Method: Bayesian model averaging (Hoeting et al., 1999).
void mix(const std::vector<PossiblePose>& poses, PoseFit& fit);

}  // namespace robsim::fit
