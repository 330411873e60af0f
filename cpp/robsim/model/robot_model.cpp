#include "robsim/model/robot_model.hpp"

#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/system.hpp"

namespace robsim {

namespace {

void require(bool holds, const char* name, const char* expected, double value, const char* why) {
  if (holds) return;
  throw std::invalid_argument(std::string(name) + " must be " + expected + ", got " +
                              to_text(value) + ": " + why);
}

void check_positive(const char* name, double value, const char* why) {
  require(std::isfinite(value) && value > 0, name, "positive and finite", value, why);
}

void check_friction(const char* name, double value) {
  require(std::isfinite(value) && value >= 0, name, "at least 0 and finite", value,
          "friction cannot drive the robot");
}

void check_finite(const char* name, const std::array<double, 2>& values) {
  for (const double value : values) {
    require(std::isfinite(value), name, "finite", value, "a motor needs a torque");
  }
}

}  // namespace

void check_parameters(const RobotParameters& p) {
  check_positive("mass", p.mass, "a body has a mass (kg)");
  check_positive("inertia", p.inertia, "a body has a moment of inertia (kg m^2)");
  check_positive("wheel_radius", p.wheel_radius, "a wheel has a radius (m)");
  check_positive("wheel_base", p.wheel_base, "the wheels stand apart (m)");
  check_positive("dt", p.dt, "time goes on from step to step (s)");
  check_friction("linear_friction", p.linear_friction);
  check_friction("angular_friction", p.angular_friction);
  check_finite("motor_gain", p.motor_gain);
  check_finite("motor_offset", p.motor_offset);
}

namespace {

AxisMatrix predictor_parameters(const RobotParameters& p) {
  check_parameters(p);
  const double T = p.dt;
  const double r = p.wheel_radius;
  const auto [alpha1, alpha2] = p.motor_gain;
  const auto [beta1, beta2] = p.motor_offset;
  // DX = m/T^2 + Fv/T,  DP = I/T^2 + Fw/T
  const double DX = p.mass / (T * T) + p.linear_friction / T;
  const double DP = p.inertia / (T * T) + p.angular_friction / T;
  // a1X = (2m/T^2 + Fv/T)/DX = 1 + m/(m + Fv T),  a2X = 1 - a1X,  the same for P with I and Fw
  const double a1X = 1 + p.mass / (p.mass + p.linear_friction * T);
  const double a1P = 1 + p.inertia / (p.inertia + p.angular_friction * T);
  // biX = (alpha_i/r)/DX,  d1X = ((beta_1 + beta_2)/r)/DX
  Eigen::Matrix<double, 1, 5> x;
  x << a1X, 1 - a1X, alpha1 / r / DX, alpha2 / r / DX, (beta1 + beta2) / r / DX;
  // b1P = L/(2r) alpha_1/DP,  b2P = -L/(2r) alpha_2/DP,  d1P = L/(2r) (beta_1 - beta_2)/DP
  const double lever = p.wheel_base / (2 * r);
  AxisMatrix theta;
  theta.row(0) = x;
  theta.row(1) = x;
  theta.row(2) << a1P, 1 - a1P, lever * alpha1 / DP, -lever * alpha2 / DP,
      lever * (beta1 - beta2) / DP;
  if (!theta.allFinite()) {
    throw std::invalid_argument(
        "mass, inertia, wheel_radius, wheel_base, motor_gain, motor_offset and dt must give finite "
        "predictor parameters: one of them is too small or too large");
  }
  return theta;
}

// The poles z of x(k) = a1 x(k-1) + a2 x(k-2): z^2 = a1 z + a2. One lies at 1 in every robot; an
// estimated predictor may miss that by a little.
void check_poles(const AxisMatrix& theta) {
  for (int axis = 0; axis < 3; ++axis) {
    const double half = theta(axis, 0) / 2;
    const double square = half * half + theta(axis, 1);
    const double largest = square < 0 ? std::sqrt(-theta(axis, 1)) : half + std::sqrt(square);
    if (largest <= 1.1) continue;
    std::ostringstream message;
    const char name = "XYP"[axis];
    message << "a1" << name << " and a2" << name << " must give a stable predictor, got a pole at "
            << largest << ": in every robot a2" << name << " = 1 - a1" << name;
    throw std::invalid_argument(message.str());
  }
}

void check_stable(const AxisMatrix& theta) {
  const char* const names[] = {"a1X", "a1Y", "a1P"};
  const char* const causes[] = {"linear_friction", "linear_friction", "angular_friction"};
  for (int axis = 0; axis < 3; ++axis) {
    const double a1 = theta(axis, 0);
    if (a1 > 0 && a1 < 2) continue;
    std::ostringstream message;
    message << names[axis] << " must lie between 0 and 2 for a stable predictor, got " << a1;
    if (a1 >= 2) {
      message << ": enlarge " << causes[axis] << " or dt, or reduce "
              << (axis == 2 ? "inertia" : "mass");
    }
    throw std::invalid_argument(message.str());
  }
  check_poles(theta);
}

}  // namespace

namespace {

elementary::SinCos turn_of(double heading, const KnownTurn& known) {
  return known ? *known : elementary::sin_cos(heading);
}

// theta(k-2) = theta(k-1) - wrap(theta(k-1) - theta(k-2)), theta here the heading
double heading_before(const Pose& pose_1, const Pose& pose_2) {
  return pose_1.heading - wrap_angle(pose_1.heading - pose_2.heading);
}

}  // namespace

AxisMatrix regressors(const UnwrappedPose& pose_1, const UnwrappedPose& pose_2, const Input& u,
                      const KnownTurn& turn) {
  const auto [sin, cos] = turn_of(pose_1[2], turn);
  AxisMatrix phi;
  phi << pose_1[0], pose_2[0], u.u1 * cos, u.u2 * cos, cos,  //
      pose_1[1], pose_2[1], u.u1 * sin, u.u2 * sin, sin,     //
      pose_1[2], pose_2[2], u.u1, u.u2, 1;
  return phi;
}

namespace {

// x(k) = a1X x(k-1) + a2X x(k-2) + (b1X u1(k-1) + b2X u2(k-1) + d1X) cos heading(k-1), and so on.
// In an order that is written down: Eigen's depends on its version and on the processor's vectors.
double next_of(const double* theta, double value_1, double value_2, const Input& u, double drive) {
  return ((value_1 * theta[0] + u.u1 * drive * theta[2]) +
          (value_2 * theta[1] + u.u2 * drive * theta[3])) +
         drive * theta[4];
}

}  // namespace

UnwrappedPose predict(const AxisMatrix& theta, const UnwrappedPose& pose_1,
                      const UnwrappedPose& pose_2, const Input& u) {
  const auto [sin, cos] = elementary::sin_cos(pose_1[2]);
  return {next_of(&theta(0, 0), pose_1[0], pose_2[0], u, cos),
          next_of(&theta(1, 0), pose_1[1], pose_2[1], u, sin),
          next_of(&theta(2, 0), pose_1[2], pose_2[2], u, 1)};
}

PoseJacobian jacobian(const AxisMatrix& theta, const UnwrappedPose& pose_1, const Input& u) {
  PoseJacobian J = PoseJacobian::Zero();
  // d pose(k) / d pose(k-1) = a1,  d pose(k) / d pose(k-2) = a2
  J.leftCols<3>().diagonal() = theta.col(0);
  J.rightCols<3>().diagonal() = theta.col(1);
  // d x(k) / d heading(k-1) = -(b1X u1(k-1) + b2X u2(k-1) + d1X) sin heading(k-1), with cos for y
  const Eigen::Vector3d drive = theta.rightCols<3>() * Eigen::Vector3d(u.u1, u.u2, 1);
  const auto [sin, cos] = elementary::sin_cos(pose_1[2]);
  J(0, 2) = -drive[0] * sin;
  J(1, 2) = drive[1] * cos;
  return J;
}

Regression regression(const Pose& pose, const Pose& pose_1, const Pose& pose_2, const Input& u,
                      const KnownTurn& turn) {
  const double heading = pose_1.heading + wrap_angle(pose.heading - pose_1.heading);
  return {regressors({pose_1.x, pose_1.y, pose_1.heading},
                     {pose_2.x, pose_2.y, heading_before(pose_1, pose_2)}, u, turn),
          {pose.x, pose.y, heading}};
}

bool is_multiple(double time, double dt) {
  const double steps = std::round(time / dt);
  return steps >= 1 && steps <= std::numeric_limits<int>::max() &&
         std::abs(time - steps * dt) <= dt / 4;
}

int model_steps(double time, double dt) {
  if (is_multiple(time, dt)) return static_cast<int>(std::round(time / dt));
  std::ostringstream message;
  message << "step.dt must be a multiple of the model's dt, " << dt << " s, got " << time
          << ": the model must have the dt of the frames, as sim.model has that of the run";
  throw std::invalid_argument(message.str());
}

RobotModel::RobotModel(const RobotParameters& parameters)
    : RobotModel(predictor_parameters(parameters), parameters.dt) {}

RobotModel::RobotModel(const AxisMatrix& theta, double dt) : theta_(theta), dt_(dt) {
  if (!theta.allFinite()) throw std::invalid_argument("theta must be finite, got NaN or inf");
  checked(dt, std::isfinite(dt) && dt > 0, "dt must be positive and finite (s)");
  check_stable(theta);
}

Pose RobotModel::predict(const Pose& pose_1, const Pose& pose_2, const Input& u,
                         const KnownTurn& turn) const {
  const auto [sin, cos] = turn_of(pose_1.heading, turn);
  return {next_of(&theta_(0, 0), pose_1.x, pose_2.x, u, cos),
          next_of(&theta_(1, 0), pose_1.y, pose_2.y, u, sin),
          wrap_angle(next_of(&theta_(2, 0), pose_1.heading, heading_before(pose_1, pose_2), u, 1))};
}

UnwrappedPose RobotModel::predict(const UnwrappedPose& pose_1, const UnwrappedPose& pose_2,
                                  const Input& u) const {
  return robsim::predict(theta_, pose_1, pose_2, u);
}

PoseJacobian RobotModel::jacobian(const UnwrappedPose& pose_1, const Input& u) const {
  return robsim::jacobian(theta_, pose_1, u);
}

void check_mean_interval(double time, std::int64_t n_steps, double dt) {
  constexpr std::int64_t fewest_steps = 10;
  constexpr double tolerance = 0.05;  // of dt
  const double mean = time / static_cast<double>(n_steps);
  if (n_steps < fewest_steps || std::abs(mean - dt) <= tolerance * dt) return;
  std::ostringstream message;
  message << "step.dt must be a multiple of the model's dt, " << dt << " s, got " << mean
          << " on average: the model must have the dt of the frames, as sim.model has that of the "
             "run";
  throw std::invalid_argument(message.str());
}

int RobotModel::steps_in(double time) const { return model_steps(time, dt_); }

}  // namespace robsim
