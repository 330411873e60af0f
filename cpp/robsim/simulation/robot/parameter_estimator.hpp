#pragma once

#include <memory>

#include "robsim/estimation/recursive_least_squares.hpp"
#include "robsim/simulation/robot/step.hpp"

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
};

/// The default: recursive least squares, one filter for each of the three axes.
class RecursiveEstimator : public ParameterEstimator {
 public:
  explicit RecursiveEstimator(std::shared_ptr<RecursiveLeastSquares> filters);

  AxisMatrix update(const Step& step) override;
  bool has_standard_errors() const override { return true; }
  bool write_standard_errors_unscaled(double* errors) const override;
  const std::shared_ptr<RecursiveLeastSquares>& filters() const { return filters_; }

 private:
  std::shared_ptr<RecursiveLeastSquares> filters_;
};

}  // namespace robsim
