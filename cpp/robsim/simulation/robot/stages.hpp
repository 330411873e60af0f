#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "robsim/estimation/recursive_least_squares.hpp"
#include "robsim/simulation/robot/step.hpp"
#include "robsim/simulation/seam/observation.hpp"
#include "robsim/simulation/seam/thread_guard.hpp"

namespace robsim {

/// What a simulation identifies its robot with, sample by sample.
class ParameterEstimator {
 public:
  virtual ~ParameterEstimator() = default;

  /// Takes the step's sample in and returns the parameters estimated by now.
  virtual AxisMatrix update(Step& step) = 0;

  /// Throws unless it can be updated.
  virtual void check() const {}

  /// True if it knows the standard errors of its estimates.
  virtual bool has_standard_errors() const { return false; }

  /// Writes them in units of the noise, 3 x 5 numbers; false, if there are none yet.
  virtual bool write_standard_errors_unscaled(double*) const { return false; }

  /// True if it needs the Python interpreter.
  virtual bool is_interpreted() const { return false; }

  /// What gives it to one run at a time; null if the interpreter sees to that.
  virtual const ThreadGuard* guard() const { return nullptr; }
};

/// Recursive least squares that runs and others have in turn.
class GuardedLeastSquares : public RecursiveLeastSquares {
 public:
  using RecursiveLeastSquares::RecursiveLeastSquares;

  const ThreadGuard& guard() const { return guard_; }

 private:
  ThreadGuard guard_{
      "a run in another thread has this estimator as long as it lasts: look at "
      "sim.trace.parameters meanwhile; simulations that run at a time need an estimator each",
      "a run in another thread had this estimator when the process was forked, and may have been "
      "in the middle of an update: make another one in this process"};
};

/// The default: recursive least squares, one filter for each of the three axes.
class RecursiveEstimator : public ParameterEstimator {
 public:
  explicit RecursiveEstimator(std::shared_ptr<GuardedLeastSquares> filters);

  AxisMatrix update(Step& step) override;
  bool has_standard_errors() const override { return true; }
  bool write_standard_errors_unscaled(double* errors) const override;
  const ThreadGuard* guard() const override { return &filters_->guard(); }
  const std::shared_ptr<GuardedLeastSquares>& filters() const { return filters_; }

 private:
  std::shared_ptr<GuardedLeastSquares> filters_;
};

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

// What fills the slots of the robot half where nobody gives anything else.

RobotModel default_model();
std::shared_ptr<ParameterEstimator> default_parameter_estimator(const RobotModel& model);

/// Gives the step's sample, if there is one, to the step's estimator.
std::optional<AxisMatrix> update_estimator(const StepPointer& step);

}  // namespace robsim
