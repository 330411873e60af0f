#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "robsim/simulation/robot/parameter_estimator.hpp"
#include "robsim/simulation/robot/step.hpp"
#include "robsim/simulation/seam/slot.hpp"

namespace robsim {

/// The slots of the robot half.
struct Stages {
  // Once, at the start, in this order.
  std::function<RobotModel()> define_model;
  std::function<std::shared_ptr<ParameterEstimator>(const RobotModel&)> init_parameter_estimator;

  // At every step, in this order. Empty: no such stage.
  Slot<std::optional<AxisMatrix>(const StepPointer&)> estimate_parameters;
  Slot<std::optional<Measurement>(const StepPointer&)> measure;
  Slot<Estimate(const StepPointer&)> estimate_state;
  Slot<Input(const StepPointer&)> control;
};

}  // namespace robsim
