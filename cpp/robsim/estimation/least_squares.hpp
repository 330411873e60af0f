#pragma once

#include <Eigen/Core>
#include <cstddef>

namespace robsim {

/// What full rank is, for all estimates from regressors. Their columns are scaled to length 1;
/// singular values up to this fraction of the largest are rounding errors. An unknown is not
/// determined if more than this fraction of the square of its direction belongs to these.
constexpr double rank_tolerance = 1e-10;

struct LeastSquaresFit {
  Eigen::VectorXd theta;  // NaN where the data do not determine a parameter
  int rank = 0;
  double condition = 0;     // largest over smallest singular value, columns of length 1
  double residual_rms = 0;  // root mean square of y - phi theta

  // Square roots of the diagonal of (phi' phi)^-1: standard errors in units of the standard
  // deviation of the noise. Infinite where theta is NaN.
  Eigen::VectorXd standard_errors_unscaled;

  // The same times the standard deviation of the noise, estimated from the residuals with
  // samples - rank degrees of freedom. NaN if there are none.
  Eigen::VectorXd standard_errors;
};

/// The theta that minimises |y - phi theta|, one sample per row: Householder reflections reduce phi
/// and y to a triangle, block by block of rows (Golub and Van Loan, Matrix Computations, 5.2.2),
/// its columns are scaled to length 1, and its singular values determine the rank (5.5).
/// Throws std::invalid_argument if phi is empty, y has another length, or a value is not finite.
LeastSquaresFit least_squares(
    const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>&
        phi,
    const Eigen::Ref<const Eigen::VectorXd>& y);

/// s(k) = a1 s(k-1) + a2 s(k-2) + force(k), column by column of row-major arrays; s is 0 before the
/// first row.
void second_order_recursion(double a1, double a2, const double* force, double* s, std::size_t rows,
                            std::size_t columns);

}  // namespace robsim
