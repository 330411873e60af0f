#pragma once

#include <vector>

#include "robsim/simulation/robot/step.hpp"

namespace robsim {

/// A controller that needs no interpreter. It has no memory: its input depends on the step alone,
/// so that one object serves any number of runs.
class Controller {
 public:
  virtual ~Controller() = default;
  virtual Input operator()(const Step& step) const = 0;
};

/// Turns on the spot: (+voltage, -voltage).
class Spin : public Controller {
 public:
  /// Throws std::invalid_argument unless the voltage (V) is finite.
  explicit Spin(double voltage = 0.05);

  Input operator()(const Step& step) const override;
  double voltage() const { return voltage_; }

 private:
  double voltage_;
};

/// Drives around: for each motor a random voltage, uniform in [low, high) V, held for `hold` steps.
class DriveAround : public Controller {
 public:
  /// Throws std::invalid_argument unless low <= high, both finite, and hold >= 1.
  explicit DriveAround(double low = -0.5, double high = 1.5, int hold = 10);

  Input operator()(const Step& step) const override;
  double low() const { return low_; }
  double high() const { return high_; }
  int hold() const { return hold_; }

 private:
  double low_;
  double high_;
  int hold_;
};

/// Gives recorded inputs once more: in step k that of row k.
class Replay : public Controller {
 public:
  /// Throws std::invalid_argument unless all inputs (V) are finite.
  explicit Replay(std::vector<Input> u);

  /// Throws std::out_of_range if there is no input for the step.
  Input operator()(const Step& step) const override;
  const std::vector<Input>& u() const { return u_; }

 private:
  std::vector<Input> u_;
};

}  // namespace robsim
