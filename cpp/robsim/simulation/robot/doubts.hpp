#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "robsim/simulation/robot/step.hpp"

namespace robsim {

/// Implausible results of stages, in words; each kind once per run.
class Doubts {
 public:
  void look_at(const Measurement& measurement, std::int64_t k);
  void look_at(const Estimate& estimate, std::int64_t k);
  void look_at(const Input& u, std::int64_t k);

  const std::vector<std::string>& texts() const { return texts_; }

 private:
  void add(bool& is_told, std::int64_t k, const std::string& text);

  std::vector<std::string> texts_;
  bool is_told_of_heading_ = false;
  bool is_told_of_covariance_ = false;
  bool is_told_of_voltage_ = false;
  double last_heading_ = std::numeric_limits<double>::quiet_NaN();  // as given (rad)
};

}  // namespace robsim
