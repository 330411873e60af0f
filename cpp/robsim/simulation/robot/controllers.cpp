#include "robsim/simulation/robot/controllers.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/system.hpp"

namespace robsim {

void Spin::check() const {
  if (!std::isfinite(voltage)) throw std::invalid_argument("voltage must be finite (V)");
}

Input Spin::operator()(const Step&) const { return {voltage, -voltage}; }

void DriveAround::check() const {
  if (!(std::isfinite(low) && std::isfinite(high) && low <= high)) {
    throw std::invalid_argument("low must not be above high, both finite (V), got low=" +
                                to_text(low) + " and high=" + to_text(high));
  }
  checked(hold, hold >= 1, "hold must be at least 1 step");
}

Input DriveAround::operator()(const Step& step) const {
  const auto block = static_cast<std::uint64_t>(step.k / hold);
  const auto voltage = [&](std::uint64_t motor) {
    return low + (high - low) * random_uniform(step.controller_seed, 2 * block + motor);
  };
  return {voltage(0), voltage(1)};
}

Replay::Replay(std::vector<Input> u) : u_(std::move(u)) {
  const auto is_finite = [](const Input& input) {
    return std::isfinite(input.u1) && std::isfinite(input.u2);
  };
  if (!std::all_of(u_.begin(), u_.end(), is_finite)) {
    throw std::invalid_argument("u must be finite (V)");
  }
}

Input Replay::operator()(const Step& step) const {
  const auto rows = static_cast<std::int64_t>(u_.size());
  if (step.k >= 0 && step.k < rows) return u_[static_cast<std::size_t>(step.k)];
  throw std::out_of_range("the recorded inputs have " + std::to_string(rows) +
                          " rows, there is none for step " + std::to_string(step.k));
}

}  // namespace robsim
