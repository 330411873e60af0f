#include "robsim/vision/fit/pose_mixture.hpp"

#include <algorithm>

#include "robsim/base/geometry.hpp"

namespace robsim::fit {

Eigen::Vector3d shift_between(const Pose& from, const Pose& to) {
  return {to.x - from.x, to.y - from.y, wrap_angle(to.heading - from.heading)};
}

void mix(const std::vector<PossiblePose>& poses, PoseFit& fit) {
  double all = 0;
  for (const PossiblePose& pose : poses) all += pose.odds;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  PoseCovariance covariance = PoseCovariance::Zero();
  for (const PossiblePose& pose : poses) {
    const double share = pose.odds / all;
    mean += share * pose.shift;
    covariance += share * (pose.covariance + pose.shift * pose.shift.transpose());
  }
  covariance -= mean * mean.transpose();
  const Eigen::Array3d growth = covariance.diagonal().array() / fit.covariance.diagonal().array();
  fit.misfit *= std::max(1.0, growth.maxCoeff());
  fit.covariance = covariance;
  fit.pose.x += mean[0];
  fit.pose.y += mean[1];
  fit.pose.heading = wrap_angle(fit.pose.heading + mean[2]);
}

}  // namespace robsim::fit
