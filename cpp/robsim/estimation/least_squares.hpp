#pragma once

#include <Eigen/Core>

namespace robsim {

struct LeastSquaresFit {
  Eigen::VectorXd theta;  // NaN where the data say nothing about a parameter
  int rank = 0;
  double condition = 0;     // first over last diagonal element of R: an estimate, from below
  double residual_rms = 0;  // root mean square of y - phi theta

  // Square roots of the diagonal of (phi' phi)^-1: standard errors in units of the standard
  // deviation of the noise. Infinite where theta is NaN.
  Eigen::VectorXd standard_errors_unscaled;

  // The same times the noise's standard deviation estimated from the residuals, which has
  // samples - rank degrees of freedom. NaN if there are none.
  Eigen::VectorXd standard_errors;
};

/// The theta that minimises |y - phi theta|, one sample a row: phi and y are reduced to a triangle
/// by Householder reflections, block after block of rows (Golub and Van Loan, Matrix Computations,
/// 5.2.2), its columns scaled to length 1, and the rank found by QR with column pivoting (5.4.2).
/// Throws std::invalid_argument unless there are samples, as many outputs, all finite.
LeastSquaresFit least_squares(
    const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>&
        phi,
    const Eigen::Ref<const Eigen::VectorXd>& y);

}  // namespace robsim
