#pragma once

#include <memory>
#include <optional>

#include "robsim/simulation/robot/parameter_estimator.hpp"
#include "robsim/simulation/robot/step.hpp"

namespace robsim {

// What fills the slots of the robot half where nobody gives anything else.

RobotModel default_model();
std::shared_ptr<ParameterEstimator> default_parameter_estimator(const RobotModel& model);

/// Gives the step's sample, if there is one, to the step's estimator.
std::optional<AxisMatrix> update_estimator(const StepPointer& step);

/// Locates the two markers among the step's blobs.
std::optional<Measurement> locate_markers(const StepPointer& step);

}  // namespace robsim
