#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "robsim/simulation/parameter_estimator.hpp"
#include "robsim/simulation/step.hpp"
#include "robsim/world/renderer.hpp"

namespace robsim {

/// One stage: a native component or a Python callable. Empty = off.
template <typename Signature>
struct Slot {
  std::function<Signature> call;
  bool is_interpreted = false;

  explicit operator bool() const { return static_cast<bool>(call); }
};

using StepPointer = std::shared_ptr<Step>;

struct Stages {
  // Once, at the start, in this order.
  std::function<RobotModel()> define_model;
  std::function<std::shared_ptr<ParameterEstimator>(const RobotModel&)> init_parameter_estimator;
  std::function<Renderer()> make_renderer;  // adjusts the background

  // Instead of the simulated world: the frame of step k from a recording or a camera, nothing at
  // its end. Empty: the world is simulated.
  std::function<std::optional<Frame>(std::int64_t k)> take_frame;

  // At every step, in this order. Empty: the robot's own model, and for the others no such stage.
  // There is always a controller in a simulated world.
  Slot<Pose(const WorldState&)> evaluate_model;
  Slot<std::optional<AxisMatrix>(const StepPointer&)> estimate_parameters;
  Slot<std::optional<Measurement>(const StepPointer&)> measure;
  Slot<Estimate(const StepPointer&)> estimate_state;
  Slot<Input(const StepPointer&)> control;
};

/// What the loop needs of the interpreter around it.
class Interpreter {
 public:
  virtual ~Interpreter() = default;
  virtual void release() = 0;
  virtual void acquire() = 0;

  /// Called between two steps every 50 ms or so, while the interpreter is held. May throw, which
  /// ends the run.
  virtual void between_steps(std::int64_t done) = 0;
};

}  // namespace robsim
