#include "robsim/estimation/least_squares.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/base/simd/lanes.hpp"

namespace robsim {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using simd::Lanes;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

// Rows reduced at a time: with a few columns they stay in the cache.
constexpr Index block_rows = 256;
constexpr Index stride =
    4 * Lanes::count;  // four independent sums hide the latency of the additions
static_assert(block_rows % stride == 0);

// a'b of two columns of a block.
ROBSIM_INLINE double dot(const double* a, const double* b) {
  constexpr int lane_count = Lanes::count;
  Lanes sums[4] = {Lanes::all(0), Lanes::all(0), Lanes::all(0), Lanes::all(0)};
  for (Index i = 0; i < block_rows; i += stride) {
    ROBSIM_UNROLL
    for (int k = 0; k < 4; ++k) {
      const Index at = i + k * lane_count;
      sums[k] = sums[k] + Lanes::load(a + at) * Lanes::load(b + at);
    }
  }
  double parts[lane_count];
  ((sums[0] + sums[1]) + (sums[2] + sums[3])).store(parts);
  return (parts[0] + parts[1]) + (parts[2] + parts[3]);
}

// b <- b - factor a
ROBSIM_INLINE void subtract(double factor, const double* a, double* b) {
  const Lanes factors = Lanes::all(factor);
  for (Index i = 0; i < block_rows; i += Lanes::count) {
    (Lanes::load(b + i) - factors * Lanes::load(a + i)).store(b + i);
  }
}

// Replaces R by the triangle of the QR of R with the rows of a block below it.
ROBSIM_INLINE void append(MatrixXd& R, MatrixXd& block) {
  for (Index k = 0; k < R.cols(); ++k) {
    const double* const column = block.col(k).data();
    const double below = dot(column, column);
    if (below == 0) continue;
    // H = I - beta v v',  v = (R_kk - length; column),  H (R_kk; column) = (length; 0)
    const double length = -std::copysign(std::sqrt(R(k, k) * R(k, k) + below), R(k, k));
    const double v = R(k, k) - length;
    const double beta = 2 / (v * v + below);
    R(k, k) = length;
    for (Index j = k + 1; j < R.cols(); ++j) {
      double* const other = block.col(j).data();
      const double factor = beta * (v * R(k, j) + dot(column, other));
      R(k, j) -= factor * v;
      subtract(factor, column, other);
    }
  }
}

// The triangle R of the QR of (phi y).
MatrixXd triangle(const Eigen::Ref<const Rows>& phi, const Eigen::Ref<const VectorXd>& y) {
  const auto append_block = ROBSIM_PICK(append);
  const Index n = phi.cols();
  MatrixXd R = MatrixXd::Zero(n + 1, n + 1);
  MatrixXd block(block_rows, n + 1);
  for (Index row = 0; row < phi.rows(); row += block_rows) {
    const Index rows = std::min(block_rows, phi.rows() - row);
    block.topLeftCorner(rows, n) = phi.middleRows(row, rows);
    block.col(n).head(rows) = y.segment(row, rows);
    block.bottomRows(block_rows - rows).setZero();
    append_block(R, block);
  }
  return R;
}

void check_samples(const Eigen::Ref<const Rows>& phi, const Eigen::Ref<const VectorXd>& y) {
  if (phi.rows() == 0 || phi.cols() == 0) throw std::invalid_argument("phi must not be empty");
  if (phi.rows() != y.size()) {
    throw std::invalid_argument("y must have as many samples as phi has rows, got " +
                                std::to_string(y.size()) + " and " + std::to_string(phi.rows()));
  }
}

}  // namespace

LeastSquaresFit least_squares(const Eigen::Ref<const Rows>& phi,
                              const Eigen::Ref<const VectorXd>& y) {
  check_samples(phi, y);
  const Index n = phi.cols();
  const MatrixXd R = triangle(phi, y);
  if (!std::isfinite(R.squaredNorm())) {  // NaN and overflow propagate to R
    throw std::invalid_argument("phi and y must be finite and at most 1e100");
  }
  VectorXd scale = R.topLeftCorner(n, n).colwise().norm().transpose();
  scale = (scale.array() > 0).select(scale, 1.0);
  // R11 / scale = U diag(s) V'
  const Eigen::JacobiSVD<MatrixXd, Eigen::NoQRPreconditioner> svd(  // which only oblongs need
      R.topLeftCorner(n, n) * scale.cwiseInverse().asDiagonal(),
      Eigen::ComputeFullU | Eigen::ComputeFullV);
  const VectorXd& s = svd.singularValues();
  const Index rank = (s.array() > rank_tolerance * s[0]).count();
  const VectorXd reached = svd.matrixU().transpose() * R.col(n).head(n);
  const MatrixXd directions = svd.matrixV().leftCols(rank);
  const MatrixXd inverse = directions * s.head(rank).cwiseInverse().asDiagonal();
  LeastSquaresFit fit;
  fit.rank = static_cast<int>(rank);
  const double smallest = phi.rows() < n ? 0 : s[n - 1];
  fit.condition = smallest > 0 ? s[0] / smallest : infinity;
  // theta = V s^-1 U' y, and (phi' phi)^-1 = V s^-2 V'
  fit.theta = (inverse * reached.head(rank)).cwiseQuotient(scale);
  fit.standard_errors_unscaled = inverse.rowwise().norm().cwiseQuotient(scale);
  // |y - phi theta|: what of y is outside the range of phi, or beyond its rank
  const double residual = Eigen::Vector2d(reached.tail(n - rank).norm(), R(n, n)).stableNorm();
  const auto freedom = static_cast<double>(phi.rows() - rank);
  fit.residual_rms = residual / std::sqrt(static_cast<double>(phi.rows()));
  fit.standard_errors =
      fit.standard_errors_unscaled * (freedom > 0 ? residual / std::sqrt(freedom) : nan);
  if (rank < n) {
    const auto is_free = (1 - directions.rowwise().squaredNorm().array() > rank_tolerance).eval();
    fit.theta = is_free.select(nan, fit.theta);
    for (VectorXd* errors : {&fit.standard_errors_unscaled, &fit.standard_errors}) {
      *errors = is_free.select(infinity, *errors);
    }
  }
  return fit;
}

void second_order_recursion(double a1, double a2, const double* force, double* s, std::size_t rows,
                            std::size_t columns) {
  const std::vector<double> before(columns, 0.0);
  const double* last = before.data();
  const double* last_but_one = before.data();
  for (std::size_t k = 0; k < rows; ++k) {
    for (std::size_t i = 0; i < columns; ++i) {
      s[i] = a1 * last[i] + a2 * last_but_one[i] + force[i];
    }
    last_but_one = last;
    last = s;
    s += columns;
    force += columns;
  }
}

}  // namespace robsim
