#include "robsim/estimation/recursive_least_squares.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace robsim {

namespace {

constexpr double largest = 1e100;  // squares of larger numbers overflow

template <typename Number>
void check(bool holds, const char* expected, Number value) {
  if (!holds) throw std::invalid_argument(expected + std::to_string(value));
}

// Without excitation forgetting lets the covariance grow for ever: it ends here, before numbers
// overflow.
double most_covariance(const RecursiveLeastSquares& filter) {
  return std::max(1e15, filter.initial_covariance());
}

bool is_usable(const Eigen::Ref<const RecursiveLeastSquares::Rows>& values) {
  return (values.array().abs() <= largest).all();  // false for NaN, too
}

}  // namespace

RecursiveLeastSquares::RecursiveLeastSquares(int parameters, int filters, double forgetting,
                                             double initial_covariance)
    : forgetting_(forgetting), initial_covariance_(initial_covariance) {
  check(parameters >= 1, "parameters must be at least 1, got ", parameters);
  check(filters >= 1, "filters must be at least 1, got ", filters);
  check(forgetting > 0 && forgetting <= 1, "forgetting must lie in (0, 1], got ", forgetting);
  check(std::isfinite(initial_covariance) && initial_covariance > 0,
        "initial_covariance must be positive and finite, got ", initial_covariance);
  theta_.resize(filters, parameters);
  factors_.resize(static_cast<std::size_t>(filters));
  for (Eigen::VectorXd* vector : {&f_, &v_, &gain_}) vector->resize(parameters);
  reset();
}

void RecursiveLeastSquares::reset() {
  theta_.setZero();
  for (Factors& p : factors_) {
    p.U = Eigen::MatrixXd::Identity(parameters(), parameters());
    p.D = Eigen::VectorXd::Constant(parameters(), initial_covariance_);
  }
}

void RecursiveLeastSquares::update(const Eigen::Ref<const Rows>& phi,
                                   const Eigen::Ref<const Eigen::VectorXd>& y) {
  if (!is_usable(phi) || !is_usable(y)) {
    throw std::invalid_argument("phi and y must be finite and at most 1e100");
  }
  for (int filter = 0; filter < filters(); ++filter) {
    auto& [U, D] = factors_[static_cast<std::size_t>(filter)];
    const double innovation = y[filter] - phi.row(filter).dot(theta_.row(filter));
    // f = U' phi,  v = D f
    f_.noalias() = U.transpose() * phi.row(filter).transpose();
    v_ = D.cwiseProduct(f_);
    // alpha_j = alpha_(j-1) + f_j v_j,  D_j <- D_j alpha_(j-1)/(alpha_j lambda)
    double alpha = forgetting_;
    for (int j = 0; j < parameters(); ++j) {
      const double previous = alpha;
      alpha += f_[j] * v_[j];
      D[j] = std::min(D[j] * previous / (alpha * forgetting_), most_covariance(*this));
      gain_[j] = v_[j];
      // U_ij <- U_ij - b_i f_j/alpha_(j-1),  b_i <- b_i + U_ij v_j
      for (int i = 0; i < j; ++i) {
        const double u = U(i, j);
        U(i, j) = u - gain_[i] * f_[j] / previous;
        gain_[i] += u * v_[j];
      }
    }
    // K = b/alpha_n,  theta <- theta + K innovation
    theta_.row(filter) += gain_.transpose() * (innovation / alpha);
  }
}

Eigen::MatrixXd RecursiveLeastSquares::covariance(int filter) const {
  const auto& [U, D] = factors_.at(static_cast<std::size_t>(filter));
  return U * D.asDiagonal() * U.transpose();
}

}  // namespace robsim
