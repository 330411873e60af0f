#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "robsim/estimation/filter_group.hpp"

namespace robsim {

/// Recursive least squares with forgetting, for one filter or any number side by side.
/// Source: Bierman, Factorization Methods for Discrete Sequential Estimation, 1977, ch. V: the
/// covariance is kept as P = U D U', so that no rounding can make it asymmetric or negative.
///
/// Without excitation forgetting would let P grow for ever. Here the trace of P never exceeds
/// `covariance_limit()`: when it would, each D_j is cut to where its share D_j |U_j|^2 of the trace
/// is at most an n-th of the limit. That adds information along single columns of U and takes none
/// away, leaves theta as it is, and cuts no column that the samples excite. Up to there it is the
/// textbook's filter.
class RecursiveLeastSquares {
 public:
  /// `parameters` of each of `filters` filters; 0 < forgetting <= 1; P starts as
  /// initial_covariance times the unit matrix, theta as 0.
  /// Throws std::invalid_argument for values outside these ranges.
  explicit RecursiveLeastSquares(int parameters, int filters = 1, double forgetting = 1,
                                 double initial_covariance = 1e9);

  int parameters() const { return parameters_; }
  int filters() const { return filters_; }
  double forgetting() const { return forgetting_; }
  double initial_covariance() const { return initial_covariance_; }

  /// What the trace of P never exceeds: 1e9 for each parameter, or what it is at the start.
  double covariance_limit() const { return groups_.front().covariance_limit(); }

  /// Samples of every filter, one after the other. A sample has the regressors of filter 0,
  /// those of filter 1, ... in phi, and their outputs in y. A filter whose own regressors or output
  /// have a NaN holds: nothing of it changes. If `history` is given, the estimates after each
  /// sample are written to it, in the order of phi. Throws std::invalid_argument for infinity and
  /// beyond 1e100, and changes nothing then.
  void update(const double* phi, const double* y, std::int64_t samples = 1,
              double* history = nullptr);

  /// The estimates, row by row (filters x parameters).
  void write_estimates(double* estimates) const;

  /// Their standard errors in units of the standard deviation of the output noise: the square roots
  /// of the diagonal of P, row by row.
  void write_standard_errors_unscaled(double* errors) const;

  /// The covariance P of one filter, in units of the variance of its output noise.
  Eigen::MatrixXd covariance(int filter) const;

  /// Samples that a filter has taken in; those at which it held do not count.
  std::int64_t samples(int filter) const;

  /// Back to the start.
  void reset();

 private:
  const FilterGroup& group_of(int filter) const {
    return groups_.at(static_cast<std::size_t>(filter / FilterGroup::most_filters));
  }

  int parameters_;
  int filters_;
  double forgetting_;
  double initial_covariance_;
  std::vector<FilterGroup> groups_;
};

}  // namespace robsim
