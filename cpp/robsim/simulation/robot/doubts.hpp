#pragma once

#include <cstdint>
#include <limits>
#include <mutex>
#include <string>
#include <vector>

#include "robsim/simulation/robot/step.hpp"

namespace robsim {

/// Implausible results of stages, in words; each kind once per run. Any thread may read them.
class Doubts {
 public:
  void clear();
  void look_at(const Measurement& measurement, std::int64_t k);
  void look_at(const Estimate& estimate, std::int64_t k);
  void look_at(const Input& u, std::int64_t k);

  std::vector<std::string> texts() const;

 private:
  void add(bool& is_told, std::int64_t k, const std::string& text);

  mutable std::mutex mutex_;  // of the texts
  std::vector<std::string> texts_;
  bool is_told_of_heading_ = false;
  bool is_told_of_covariance_ = false;
  bool is_told_of_voltage_ = false;
  double last_heading_ = std::numeric_limits<double>::quiet_NaN();  // as given (rad)
};

}  // namespace robsim
