#pragma once

#include <Eigen/Core>
#include <vector>

namespace robsim {

/// Recursive least squares with forgetting, for one filter or several side by side.
/// Source: Bierman, Factorization Methods for Discrete Sequential Estimation, 1977, ch. V: the
/// covariance is kept as P = U D U', so that no rounding can make it asymmetric or negative.
class RecursiveLeastSquares {
 public:
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// `parameters` of each of `filters` filters; 0 < forgetting <= 1; P starts as
  /// initial_covariance times the unit matrix, theta as 0.
  /// Throws std::invalid_argument for values outside these ranges.
  explicit RecursiveLeastSquares(int parameters, int filters = 1, double forgetting = 1,
                                 double initial_covariance = 1e9);

  int parameters() const { return static_cast<int>(theta_.cols()); }
  int filters() const { return static_cast<int>(theta_.rows()); }
  double forgetting() const { return forgetting_; }
  double initial_covariance() const { return initial_covariance_; }

  /// One sample of every filter: the regressors row by row (filters x parameters) and the outputs.
  /// Throws std::invalid_argument for NaN or infinity, and changes nothing then.
  void update(const Eigen::Ref<const Rows>& phi, const Eigen::Ref<const Eigen::VectorXd>& y);

  /// The estimates, row by row (filters x parameters).
  const Rows& theta() const { return theta_; }

  /// The covariance P of one filter, in units of the variance of its output noise.
  Eigen::MatrixXd covariance(int filter) const;

  /// Back to the start.
  void reset();

 private:
  struct Factors {
    Eigen::MatrixXd U;  // unit upper triangular
    Eigen::VectorXd D;
  };

  double forgetting_;
  double initial_covariance_;
  Rows theta_;
  std::vector<Factors> factors_;
  Eigen::VectorXd f_, v_, gain_;
};

}  // namespace robsim
