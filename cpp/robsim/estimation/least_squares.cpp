#include "robsim/estimation/least_squares.hpp"

#include <Eigen/QR>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace robsim {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double largest = 1e100;  // squares of larger numbers overflow

using PivotedQr = Eigen::ColPivHouseholderQR<MatrixXd>;

// The parameters along which phi does not change: R11 N1 = -R12, N2 = 1, rows in phi's order.
MatrixXd null_space(const PivotedQr& qr, Eigen::Index n) {
  const Eigen::Index rank = qr.rank();
  const MatrixXd R = qr.matrixR().topRows(rank);
  MatrixXd basis(n, n - rank);
  basis.topRows(rank) =
      -R.leftCols(rank).triangularView<Eigen::Upper>().solve(R.rightCols(n - rank));
  basis.bottomRows(n - rank).setIdentity();
  return qr.colsPermutation() * basis;
}

}  // namespace

LeastSquaresFit least_squares(const Eigen::Ref<const MatrixXd>& phi,
                              const Eigen::Ref<const VectorXd>& y) {
  if (phi.rows() == 0 || phi.cols() == 0) throw std::invalid_argument("phi must not be empty");
  if (phi.rows() != y.size()) {
    throw std::invalid_argument("y must have as many samples as phi has rows, got " +
                                std::to_string(y.size()) + " and " + std::to_string(phi.rows()));
  }
  if (!((phi.array().abs() <= largest).all() && (y.array().abs() <= largest).all())) {
    throw std::invalid_argument("phi and y must be finite and at most 1e100");
  }
  const Eigen::Index n = phi.cols();
  VectorXd scale = phi.colwise().norm().transpose();
  scale = (scale.array() > 0).select(scale, 1.0);
  const MatrixXd scaled = phi * scale.cwiseInverse().asDiagonal();
  PivotedQr qr(scaled);
  qr.setThreshold(1e-12);
  LeastSquaresFit fit;
  fit.rank = static_cast<int>(qr.rank());
  fit.theta = qr.solve(y).cwiseQuotient(scale);
  fit.residual_rms = (y - phi * fit.theta).norm() / std::sqrt(static_cast<double>(y.size()));
  const double smallest = phi.rows() < n ? 0 : std::abs(qr.matrixR()(n - 1, n - 1));
  const double infinity = std::numeric_limits<double>::infinity();
  fit.condition = smallest > 0 ? std::abs(qr.matrixR()(0, 0)) / smallest : infinity;
  if (fit.rank < n) {
    const VectorXd freedom = null_space(qr, n).rowwise().norm();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    fit.theta = (freedom.array() > 1e-9).select(nan, fit.theta);
  }
  return fit;
}

}  // namespace robsim
