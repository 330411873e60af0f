#include "robsim/model/simulated_path.hpp"

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
    path.row(k) = predict(theta, regressors(UnwrappedPose(path.row(k - 1)),
                                            UnwrappedPose(path.row(k - 2)), input(u, k - 1)));
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

}  // namespace robsim
