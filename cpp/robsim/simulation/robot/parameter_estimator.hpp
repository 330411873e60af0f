#pragma once

#include <memory>

#include "robsim/estimation/recursive_least_squares.hpp"
#include "robsim/simulation/robot/step.hpp"
#include "robsim/simulation/seam/thread_guard.hpp"

namespace robsim {

/// What a simulation identifies its robot with, sample by sample.
class ParameterEstimator {
 public:
  virtual ~ParameterEstimator() = default;

  /// Takes the step's sample in and returns the parameters estimated by now.
  virtual AxisMatrix update(const Step& step) = 0;

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

  AxisMatrix update(const Step& step) override;
  bool has_standard_errors() const override { return true; }
  bool write_standard_errors_unscaled(double* errors) const override;
  const ThreadGuard* guard() const override { return &filters_->guard(); }
  const std::shared_ptr<GuardedLeastSquares>& filters() const { return filters_; }

 private:
  std::shared_ptr<GuardedLeastSquares> filters_;
};

}  // namespace robsim
