#include "robsim/simulation/robot/default_stages.hpp"

namespace robsim {

RobotModel default_model() { return RobotModel(); }

std::shared_ptr<ParameterEstimator> default_parameter_estimator(const RobotModel&) {
  return std::make_shared<RecursiveEstimator>(std::make_shared<GuardedLeastSquares>(5, 3));
}

std::optional<AxisMatrix> update_estimator(const StepPointer& step) {
  if (!step->sample) return std::nullopt;
  return step->estimator->update(*step);
}

std::optional<Measurement> locate_markers(const StepPointer& step) { return step->detect(); }

}  // namespace robsim
