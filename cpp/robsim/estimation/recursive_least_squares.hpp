#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "robsim/estimation/filter_group.hpp"

namespace robsim {

/// Recursive least squares with forgetting, for any number of filters side by side.
/// Source: Bierman, Factorization Methods for Discrete Sequential Estimation, 1977, ch. V: the
/// covariance is kept as P = U D U', so that rounding cannot make it asymmetric or indefinite.
///
/// Without excitation forgetting lets P grow without bound. Here the trace of P never exceeds
/// `covariance_limit()`: where it would, each D_j is limited so that its part D_j |U_j|^2 of the
/// trace is at most 1/n of the limit. This adds information along single columns of U and removes
/// none, does not change theta, and does not affect columns that the samples excite. Below the
/// limit it is the textbook filter.
class RecursiveLeastSquares {
 public:
  /// `n_filters` filters of `n_parameters` parameters each; 1e-10 <= forgetting <= 1; the initial P
  /// is initial_covariance times the identity matrix, the initial theta 0. Throws
  /// std::invalid_argument for values outside these ranges.
  explicit RecursiveLeastSquares(int n_parameters, int n_filters = 1, double forgetting = 1,
                                 double initial_covariance = 1e9);

  int n_parameters() const { return n_parameters_; }
  int n_filters() const { return n_filters_; }
  double forgetting() const { return forgetting_; }
  double initial_covariance() const { return initial_covariance_; }

  /// The limit of the trace of P: 1e9 per parameter, or its initial value if that is larger.
  double covariance_limit() const { return groups_.front().covariance_limit(); }

  /// Updates every filter with a sequence of samples. A sample has the regressors of filter 0,
  /// those of filter 1, ... in phi, and their outputs in y. A filter with NaN in its sample skips
  /// the update. If `history` is given, the estimates after each sample are written to it, in the
  /// order of phi. Throws std::invalid_argument, and changes nothing, for infinity and beyond
  /// 1e50.
  void update(const double* phi, const double* y, std::int64_t samples = 1,
              double* history = nullptr);

  /// The estimates, row by row (filters x parameters).
  void write_estimates(double* estimates) const;

  /// Their standard errors in units of the standard deviation of the output noise: the square roots
  /// of the diagonal of P, row by row.
  void write_standard_errors_unscaled(double* errors) const;

  /// The covariance P of one filter, in units of the variance of its output noise.
  Eigen::MatrixXd covariance(int filter) const;

  /// The number of samples a filter has used, without skipped updates.
  std::int64_t samples(int filter) const;

  /// Returns to the initial state.
  void reset();

  /// What updates change, as numbers, for a copy elsewhere with the same options.
  std::vector<double> state() const;

  /// Throws std::invalid_argument if it is that of another number of filters or parameters, or
  /// holds numbers that no update leads to.
  void restore(const std::vector<double>& state);

 private:
  const FilterGroup& group_of(int filter) const {
    return groups_.at(static_cast<std::size_t>(filter / FilterGroup::maximum_filters));
  }

  int n_parameters_;
  int n_filters_;
  double forgetting_;
  double initial_covariance_;
  std::vector<FilterGroup> groups_;
};

}  // namespace robsim
