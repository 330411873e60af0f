#include "robsim/simulation/parameter_estimator.hpp"

#include <stdexcept>
#include <utility>

namespace robsim {

RecursiveEstimator::RecursiveEstimator(std::shared_ptr<RecursiveLeastSquares> filters)
    : filters_(std::move(filters)) {
  if (filters_->filters() != 3 || filters_->parameters() != 5) {
    throw std::invalid_argument(
        "a parameter estimator of the robot needs filters=3 and parameters=5, got filters=" +
        std::to_string(filters_->filters()) +
        " and parameters=" + std::to_string(filters_->parameters()));
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
