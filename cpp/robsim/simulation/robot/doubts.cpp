#include "robsim/simulation/robot/doubts.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "robsim/base/system.hpp"

namespace robsim {

namespace {

// Of the product of two standard deviations. A filter that began with a very large covariance
// leaves less than this by rounding.
constexpr double tolerance = 0.01;

constexpr double most_volts = 100;  // the motors of such robots take some 10 V

// The fault of a covariance whose variances are at least 0, in words; empty = none.
std::string fault_of(const PoseCovariance& P) {
  const Eigen::Vector3d sd = P.diagonal().cwiseSqrt();
  const Eigen::Matrix3d limits = sd * sd.transpose();
  for (int i = 0; i < 3; ++i) {
    for (int j = i + 1; j < 3; ++j) {
      if (std::abs(P(i, j) - P(j, i)) <= tolerance * limits(i, j)) continue;
      const std::string at = std::to_string(i) + ", " + std::to_string(j);
      const std::string mirrored = std::to_string(j) + ", " + std::to_string(i);
      return "is not symmetric: C[" + at + "] = " + to_text(P(i, j)) + ", but C[" + mirrored +
             "] = " + to_text(P(j, i));
    }
  }
  const Eigen::Matrix3d correlations =
      (limits.array() > 0)
          .select(P.array() / limits.array(), Eigen::Array33d(Eigen::Matrix3d::Identity()));
  const double least =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(correlations, Eigen::EigenvaluesOnly)
          .eigenvalues()
          .minCoeff();
  if (least >= -tolerance) return {};
  return "is not positive semidefinite: its correlations have the eigenvalue " + to_text(least);
}

}  // namespace

void Doubts::clear() {
  const std::lock_guard lock(mutex_);
  texts_.clear();
  is_told_of_heading_ = is_told_of_covariance_ = is_told_of_voltage_ = false;
  last_heading_ = std::numeric_limits<double>::quiet_NaN();
}

std::vector<std::string> Doubts::texts() const {
  const std::lock_guard lock(mutex_);
  return texts_;
}

void Doubts::look_at(const Measurement& measurement, std::int64_t k) {
  const double heading = measurement.given_heading;
  const double before = std::exchange(last_heading_, heading);
  if (is_told_of_heading_ || std::isnan(heading)) return;
  // Headings in rad stay within a turn, or go on from there without a jump; degrees do neither.
  const bool is_large = std::fmax(std::abs(heading), std::abs(before)) > 2 * pi;
  const double change = heading - before;
  const bool goes_on = std::abs(change) <= pi || std::abs(wrap_angle(change)) < 0.5;
  if (!is_large || goes_on) return;
  add(is_told_of_heading_, k,
      "measure returned the heading " + to_text(heading) +
          ": headings are in rad, and this looks like degrees");
}

void Doubts::look_at(const Estimate& estimate, std::int64_t k) {
  if (is_told_of_covariance_) return;
  const std::string fault = fault_of(estimate.covariance);
  if (fault.empty()) return;
  add(is_told_of_covariance_, k, "the covariance of estimate_state " + fault);
}

void Doubts::look_at(const Input& u, std::int64_t k) {
  if (std::max(std::abs(u.u1), std::abs(u.u2)) <= most_volts) return;
  add(is_told_of_voltage_, k,
      "control gave (" + to_text(u.u1) + ", " + to_text(u.u2) +
          ") V: the motors of such robots take some 10 V, so limit the voltages");
}

void Doubts::add(bool& is_told, std::int64_t k, const std::string& text) {
  if (std::exchange(is_told, true)) return;
  const std::lock_guard lock(mutex_);
  texts_.push_back("step " + std::to_string(k) + ": " + text);
}

}  // namespace robsim
