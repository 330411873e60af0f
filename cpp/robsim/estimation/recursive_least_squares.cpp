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

bool has_too_large(const double* values, std::int64_t count) {
  // What has no NaN in it, as a rule, is looked at in one quick pass.
  if (Eigen::Map<const Eigen::VectorXd>(values, count).squaredNorm() <= largest) return false;
  return std::any_of(values, values + count, [](double x) { return std::abs(x) > largest; });
}

}  // namespace

RecursiveLeastSquares::RecursiveLeastSquares(int parameters, int filters, double forgetting,
                                             double initial_covariance)
    : parameters_(parameters),
      filters_(filters),
      forgetting_(forgetting),
      initial_covariance_(initial_covariance) {
  check(parameters >= 1, "parameters must be at least 1, got ", parameters);
  check(filters >= 1, "filters must be at least 1, got ", filters);
  check(forgetting > 0 && forgetting <= 1, "forgetting must lie in (0, 1], got ", forgetting);
  check(std::isfinite(initial_covariance) && initial_covariance > 0,
        "initial_covariance must be positive and finite, got ", initial_covariance);
  reset();
}

void RecursiveLeastSquares::reset() {
  groups_.clear();
  for (int left = filters_; left > 0; left -= FilterGroup::most_filters) {
    groups_.emplace_back(parameters_, std::min(left, FilterGroup::most_filters), forgetting_,
                         initial_covariance_);
  }
}

void RecursiveLeastSquares::update(const double* phi, const double* y, std::int64_t samples,
                                   double* history) {
  const std::int64_t outputs = samples * filters_;
  if (has_too_large(phi, outputs * parameters_) || has_too_large(y, outputs)) {
    throw std::invalid_argument("phi and y must be at most 1e100, or NaN for no sample");
  }
  for (FilterGroup& group : groups_) {
    group.update(phi, y, samples, filters_, history);
    phi += group.filters() * parameters_;
    y += group.filters();
    if (history) history += group.filters() * parameters_;
  }
}

void RecursiveLeastSquares::write_estimates(double* estimates) const {
  for (const FilterGroup& group : groups_) {
    group.write_estimates(estimates);
    estimates += group.filters() * parameters_;
  }
}

void RecursiveLeastSquares::write_unit_errors(double* errors) const {
  for (const FilterGroup& group : groups_) {
    group.write_unit_errors(errors);
    errors += group.filters() * parameters_;
  }
}

std::int64_t RecursiveLeastSquares::samples(int filter) const {
  return group_of(filter).samples(filter % FilterGroup::most_filters);
}

Eigen::MatrixXd RecursiveLeastSquares::covariance(int filter) const {
  const FilterGroup& group = group_of(filter);
  const int lane = filter % FilterGroup::most_filters;
  Eigen::MatrixXd U = Eigen::MatrixXd::Identity(parameters_, parameters_);
  Eigen::VectorXd D(parameters_);
  for (int j = 0; j < parameters_; ++j) {
    D[j] = group.d(lane, j);
    for (int i = 0; i < j; ++i) U(i, j) = group.u(lane, i, j);
  }
  const Eigen::MatrixXd P = U * D.asDiagonal() * U.transpose();
  return P.selfadjointView<Eigen::Upper>();  // symmetric to the last bit
}

}  // namespace robsim
