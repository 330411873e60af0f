#include "robsim/simulation/robot/stages.hpp"

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

AxisMatrix RecursiveEstimator::update(Step& step) {
  const Regression& sample = step.find_sample().value().regression;
  AxisMatrix theta;
  filters_->update(sample.phi.data(), sample.y.data(), 1, theta.data());
  return theta;
}

bool RecursiveEstimator::write_standard_errors_unscaled(double* errors) const {
  if (filters_->samples(0) == 0) return false;
  filters_->write_standard_errors_unscaled(errors);
  return true;
}

RobotModel default_model() { return RobotModel(); }

std::shared_ptr<ParameterEstimator> default_parameter_estimator(const RobotModel&) {
  return std::make_shared<RecursiveEstimator>(std::make_shared<GuardedLeastSquares>(5, 3));
}

std::optional<AxisMatrix> update_estimator(const StepPointer& step) {
  if (!step->has_sample()) return std::nullopt;
  return step->estimator->update(*step);
}

}  // namespace robsim
