#include "robsim/model/motion.hpp"

#include "robsim/base/elementary/elementary.hpp"

namespace robsim {

namespace {

constexpr int first_values = 6;

Input input(const Eigen::Ref<const Inputs>& u, Eigen::Index k) { return {u(k, 0), u(k, 1)}; }

}  // namespace

Path simulated_path(const AxisMatrix& theta,
                    const Eigen::Matrix<double, 2, 3, Eigen::RowMajor>& first,
                    const Eigen::Ref<const Inputs>& u) {
  Path path(u.rows(), 3);
  path.topRows<2>() = first;
  for (Eigen::Index k = 2; k < u.rows(); ++k) {
    path.row(k) = predict(theta, path.row(k - 1), path.row(k - 2), input(u, k - 1));
  }
  return path;
}

std::vector<PathDerivatives> path_sensitivities(const AxisMatrix& theta,
                                                const Eigen::Ref<const Path>& path,
                                                const Eigen::Ref<const Inputs>& u) {
  std::vector<PathDerivatives> S(static_cast<std::size_t>(path.rows()), PathDerivatives::Zero());
  for (int axis = 0; axis < 3; ++axis) {
    S[0](axis, 2 * axis) = 1;
    S[1](axis, 2 * axis + 1) = 1;
  }
  for (std::size_t k = 2; k < S.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const UnwrappedPose pose_1 = path.row(row - 1);
    const UnwrappedPose pose_2 = path.row(row - 2);
    const PoseJacobian J = jacobian(theta, pose_1, input(u, row - 1));
    const AxisMatrix phi = regressors(pose_1, pose_2, input(u, row - 1));
    // S(k) = J1 S(k-1) + J2 S(k-2), to which the parameters of an axis add its regressors
    S[k] = J.leftCols<3>().lazyProduct(S[k - 1]) + J.rightCols<3>().lazyProduct(S[k - 2]);
    for (int axis = 0; axis < 3; ++axis) {
      S[k].block<1, 5>(axis, first_values + 5 * axis) += phi.row(axis);
    }
  }
  return S;
}

Pose Unicycle::operator()(const RobotModel& model, const Pose& pose_1, const Pose& pose_2,
                          const Input& u) const {
  const auto x = model.theta().row(0);
  // s(k-1) = (x(k-1) - x(k-2)) cos heading(k-2) + (y(k-1) - y(k-2)) sin heading(k-2)
  const elementary::SinCos before = elementary::sin_cos(pose_2.heading);
  const double step_before =
      (pose_1.x - pose_2.x) * before.cos + (pose_1.y - pose_2.y) * before.sin;
  // s(k) = -a2X s(k-1) + b1X u1(k-1) + b2X u2(k-1) + d1X
  const double step = -x[1] * step_before + x[2] * u.u1 + x[3] * u.u2 + x[4];
  // x(k) = x(k-1) + s(k) cos heading(k-1),  y(k) = y(k-1) + s(k) sin heading(k-1)
  const elementary::SinCos now = elementary::sin_cos(pose_1.heading);
  return {pose_1.x + step * now.cos, pose_1.y + step * now.sin,
          model.predict(pose_1, pose_2, u).heading};
}

}  // namespace robsim
