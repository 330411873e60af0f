#include "robsim/estimation/recursive_least_squares.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "robsim/base/system.hpp"

namespace robsim {

namespace {

// Of regressors, outputs and variances: products of larger ones overflow on the way. So do the
// variances that a smaller forgetting divides.
constexpr double maximum = 1e50;
constexpr double least_forgetting = 1e-10;
constexpr double surely_usable = maximum * maximum;  // sum of squares
constexpr int maximum_parameters = 1000;
constexpr int maximum_filters = 100'000;
constexpr double maximum_numbers = 1e8;  // of all covariances: 0.8 GB

// True only if no value is NaN or too large to square. False is inconclusive.
bool are_surely_usable(const double* values, std::int64_t count) {
  return Eigen::Map<const Eigen::VectorXd>(values, count).squaredNorm() <= surely_usable;
}

bool has_excessive(const double* values, std::int64_t count) {
  return std::any_of(values, values + count, [](double x) { return std::abs(x) > maximum; });
}

}  // namespace

RecursiveLeastSquares::RecursiveLeastSquares(int n_parameters, int n_filters, double forgetting,
                                             double initial_covariance)
    : n_parameters_(n_parameters),
      n_filters_(n_filters),
      forgetting_(forgetting),
      initial_covariance_(initial_covariance) {
  checked(n_parameters, n_parameters >= 1 && n_parameters <= maximum_parameters,
          "n_parameters must lie within 1..1000");
  checked(n_filters, n_filters >= 1 && n_filters <= maximum_filters,
          "n_filters must lie within 1..100000");
  const double numbers = 1.0 * n_filters * n_parameters * n_parameters;
  checked(numbers, numbers <= maximum_numbers, "n_filters * n_parameters^2 must be at most 1e8");
  checked(forgetting, forgetting >= least_forgetting && forgetting <= 1,
          "forgetting must lie within 1e-10..1");
  checked(initial_covariance, initial_covariance > 0 && initial_covariance <= maximum,
          "initial_covariance must be above 0 and at most 1e50");
  reset();
}

void RecursiveLeastSquares::reset() {
  groups_.clear();
  for (int left = n_filters_; left > 0; left -= FilterGroup::maximum_filters) {
    groups_.emplace_back(n_parameters_, std::min(left, FilterGroup::maximum_filters), forgetting_,
                         initial_covariance_);
  }
}

void RecursiveLeastSquares::update(const double* phi, const double* y, std::int64_t samples,
                                   double* history) {
  const std::int64_t outputs = samples * n_filters_;
  const std::int64_t regressors = outputs * n_parameters_;
  const bool is_usable = are_surely_usable(phi, regressors) && are_surely_usable(y, outputs);
  if (!is_usable && (has_excessive(phi, regressors) || has_excessive(y, outputs))) {
    throw std::invalid_argument("phi and y must be at most 1e50, or NaN for no sample");
  }
  // A single group takes all samples at once; several groups take them in turn, in memory order.
  const std::int64_t at_once = groups_.size() == 1 ? samples : 1;
  for (std::int64_t k = 0; k < samples; k += at_once) {
    for (FilterGroup& group : groups_) {
      const std::int64_t numbers = std::int64_t{group.filters()} * n_parameters_;
      group.update({phi, y, history, at_once, n_filters_, !is_usable});
      phi += numbers;
      y += group.filters();
      if (history) history += numbers;
    }
  }
}

void RecursiveLeastSquares::write_estimates(double* estimates) const {
  for (const FilterGroup& group : groups_) {
    group.write_estimates(estimates);
    estimates += group.filters() * n_parameters_;
  }
}

void RecursiveLeastSquares::write_standard_errors_unscaled(double* errors) const {
  for (const FilterGroup& group : groups_) {
    group.write_standard_errors_unscaled(errors);
    errors += group.filters() * n_parameters_;
  }
}

std::int64_t RecursiveLeastSquares::samples(int filter) const {
  return group_of(filter).samples(filter % FilterGroup::maximum_filters);
}

Eigen::MatrixXd RecursiveLeastSquares::covariance(int filter) const {
  const FilterGroup& group = group_of(filter);
  const int lane = filter % FilterGroup::maximum_filters;
  Eigen::MatrixXd U = Eigen::MatrixXd::Identity(n_parameters_, n_parameters_);
  Eigen::VectorXd D(n_parameters_);
  for (int j = 0; j < n_parameters_; ++j) {
    D[j] = group.d(lane, j);
    for (int i = 0; i < j; ++i) U(i, j) = group.u(lane, i, j);
  }
  const Eigen::MatrixXd P = U * D.asDiagonal() * U.transpose();
  return P.selfadjointView<Eigen::Upper>();  // symmetric to the last bit
}

std::vector<double> RecursiveLeastSquares::state() const {
  std::vector<double> state;
  for (const FilterGroup& group : groups_) group.append_state(state);
  return state;
}

void RecursiveLeastSquares::restore(const std::vector<double>& state) {
  if (state.size() != this->state().size()) {
    throw std::invalid_argument("state must be that of a filter of this size");
  }
  constexpr double maximum = 1e300;  // also refuses NaN
  for (const double number : state) {
    if (!(std::abs(number) <= maximum)) throw std::invalid_argument("state must be finite");
  }
  const double* next = state.data();
  for (FilterGroup& group : groups_) next = group.restore(next);
}

}  // namespace robsim
