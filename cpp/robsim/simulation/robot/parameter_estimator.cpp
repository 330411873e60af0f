#include "robsim/simulation/robot/parameter_estimator.hpp"

#include <stdexcept>
#include <utility>

namespace robsim {

RecursiveEstimator::RecursiveEstimator(std::shared_ptr<GuardedLeastSquares> filters)
    : filters_(std::move(filters)) {
  if (filters_->n_filters() != 3 || filters_->n_parameters() != 5) {
    throw std::invalid_argument(
        "a parameter estimator of the robot needs n_filters=3 and n_parameters=5, got n_filters=" +
        std::to_string(filters_->n_filters()) +
        " and n_parameters=" + std::to_string(filters_->n_parameters()));
  }
}

AxisMatrix RecursiveEstimator::update(const Step& step) {
  const Regression& sample = step.sample.value().regression;
  AxisMatrix theta;
  filters_->update(sample.phi.data(), sample.y.data(), 1, theta.data());
  return theta;
}

bool RecursiveEstimator::write_standard_errors_unscaled(double* errors) const {
  if (filters_->samples(0) == 0) return false;
  filters_->write_standard_errors_unscaled(errors);
  return true;
}

}  // namespace robsim
