// Values of the core as fields: numbers that copies and pickles are made of.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include <pybind11/pybind11.h>

#include "robsim/model/robot_model.hpp"

namespace robsim::bindings {

using Pair = std::pair<double, double>;
using Triple = std::array<double, 3>;
using Matrix = std::array<double, 15>;

inline Triple triple_of(const Pose& pose) { return {pose.x, pose.y, pose.heading}; }
inline Pose pose_of(const Triple& values) { return {values[0], values[1], values[2]}; }
inline Pair pair_of(const Input& u) { return {u.u1, u.u2}; }
inline Input input_of(const Pair& u) { return {u.first, u.second}; }

inline Matrix values_of(const AxisMatrix& matrix) {
  Matrix values;
  std::copy_n(matrix.data(), values.size(), values.begin());
  return values;
}
inline AxisMatrix matrix_of(const Matrix& values) {
  return Eigen::Map<const AxisMatrix>(values.data());
}

/// Throws py::value_error unless it is the number of a step.
inline void check_step_number(std::int64_t k) {
  if (k < 0) throw pybind11::value_error("k must be at least 0, got " + std::to_string(k));
}

}  // namespace robsim::bindings
