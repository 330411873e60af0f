#pragma once

#include <Eigen/Core>

namespace robsim {

struct LeastSquaresFit {
  Eigen::VectorXd theta;  // NaN where the data say nothing about a parameter
  int rank = 0;
  double condition = 0;     // first over last diagonal element of R: an estimate, from below
  double residual_rms = 0;  // root mean square of y - phi theta
};

/// The theta that minimises |y - phi theta|, one sample a row, by Householder QR with column
/// pivoting (Golub and Van Loan, Matrix Computations, 5.4.2) on columns scaled to length 1.
/// Throws std::invalid_argument unless there are samples, as many outputs, all finite.
LeastSquaresFit least_squares(const Eigen::Ref<const Eigen::MatrixXd>& phi,
                              const Eigen::Ref<const Eigen::VectorXd>& y);

}  // namespace robsim
