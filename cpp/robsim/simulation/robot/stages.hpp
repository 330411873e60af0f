#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "robsim/simulation/robot/parameter_estimator.hpp"
#include "robsim/simulation/robot/step.hpp"
#include "robsim/simulation/seam/slot.hpp"

namespace robsim {

/// A stage gave what its slot cannot use.
class ResultError : public std::invalid_argument {
 public:
  ResultError(std::string slot, std::int64_t k, const std::string& what)
      : std::invalid_argument(what), slot_(std::move(slot)), k_(k) {}

  const std::string& slot() const { return slot_; }
  std::int64_t k() const { return k_; }

 private:
  std::string slot_;
  std::int64_t k_;
};

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
