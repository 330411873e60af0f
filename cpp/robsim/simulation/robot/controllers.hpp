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
struct Spin : Controller {
  double voltage = 0.05;  // V

  /// Throws std::invalid_argument unless the voltage is finite.
  void check() const;
  Input operator()(const Step& step) const override;
};

/// Drives around: for each motor a random voltage, uniform in [low, high), held for `hold` steps.
struct DriveAround : Controller {
  double low = -0.5;  // V
  double high = 1.5;  // V
  int hold = 10;

  /// Throws std::invalid_argument unless low <= high, both finite, and hold >= 1.
  void check() const;
  Input operator()(const Step& step) const override;
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
