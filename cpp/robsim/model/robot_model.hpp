#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/geometry.hpp"

namespace robsim {

/// The physical robot. The defaults reproduce the true values printed in the manual of 2008.
struct RobotParameters {
  double mass = 0.3;                                  // kg
  double inertia = 0.1;                               // kg m^2
  double linear_friction = 0.1;                       // viscous, N s/m
  double angular_friction = 0.1;                      // viscous, N m s/rad
  double wheel_radius = 0.03;                         // m
  double wheel_base = 0.11;                           // m
  std::array<double, 2> motor_gain = {0.05, 0.05};    // torque per voltage, left and right, N m/V
  std::array<double, 2> motor_offset = {1e-6, 1e-6};  // torque at 0 V, left and right, N m
  double dt = 0.2;                                    // sample time, s
};

/// Throws std::invalid_argument that names the value that is not physical, and why.
void check_parameters(const RobotParameters& parameters);

/// Voltages of the left and the right motor (V).
struct Input {
  double u1 = 0;
  double u2 = 0;
};

/// Rows: the axes X, Y and P (heading). Columns: a1, a2, b1, b2, d1 of each axis, or what they
/// are multiplied with.
using AxisMatrix = Eigen::Matrix<double, 3, 5, Eigen::RowMajor>;

/// One sample of the predictor: y = (phi * theta) row by row.
struct Regression {
  AxisMatrix phi;
  Eigen::Vector3d y;
};

/// x, y and heading as a vector; the heading is not wrapped.
using UnwrappedPose = Eigen::Vector3d;

/// Derivatives of pose(k): by pose(k-1), then by pose(k-2).
using PoseJacobian = Eigen::Matrix<double, 3, 6, Eigen::RowMajor>;

/// Sine and cosine of the heading of step k-1, where they are known already.
using KnownTurn = std::optional<elementary::SinCos>;

/// The regressors of the one-step predictor after `pose_1` (step k-1) and `pose_2` (step k-2).
AxisMatrix regressors(const UnwrappedPose& pose_1, const UnwrappedPose& pose_2, const Input& u,
                      const KnownTurn& turn = {});

/// The predictor for any parameters, stable or not: pose(k) = (regressors * theta) row by row.
UnwrappedPose predict(const AxisMatrix& theta, const UnwrappedPose& pose_1,
                      const UnwrappedPose& pose_2, const Input& u);

/// Its derivatives by the poses.
PoseJacobian jacobian(const AxisMatrix& theta, const UnwrappedPose& pose_1, const Input& u);

/// The sample whose output is `pose` (step k). The headings of output and `pose_2` are taken within
/// half a turn of that of `pose_1`, without a wrapped jump.
Regression regression(const Pose& pose, const Pose& pose_1, const Pose& pose_2, const Input& u,
                      const KnownTurn& turn = {});

/// True if a time (s) is a multiple of dt, at least one, within dt / 4.
bool is_multiple(double time, double dt);

/// The number of steps of a model with this dt (s) in a time (s): several if frames were lost.
/// Throws std::invalid_argument if the time is not a multiple of dt, at least one, within dt / 4.
int model_steps(double time, double dt);

/// Single frames may jitter; throws std::invalid_argument if so many steps in a time (s), 10 or
/// more, are not dt long on average.
void check_mean_interval(double time, std::int64_t n_steps, double dt);

/// One-step predictor of a differential-drive robot, linear in its 15 parameters theta.
/// Source: Pereira et al., Data-Based Dynamical Modelling of Externally Observed Actuators-Only
/// Robots, IEEE Trans. SMC A 30(4), 2000. Nothing in the equations forbids it to slide sideways.
class RobotModel {
 public:
  /// Throws std::invalid_argument for non-physical parameters and for an unstable predictor.
  explicit RobotModel(const RobotParameters& parameters = {});

  /// The same from the 15 predictor parameters and the sample time (s).
  RobotModel(const AxisMatrix& theta, double dt);

  const AxisMatrix& theta() const { return theta_; }
  double dt() const { return dt_; }

  /// The pose of step k from those of steps k-1 and k-2 and the input of step k-1.
  Pose predict(const Pose& pose_1, const Pose& pose_2, const Input& u,
               const KnownTurn& turn = {}) const;

  /// The same with headings as they come, in and out: without a wrapped jump.
  UnwrappedPose predict(const UnwrappedPose& pose_1, const UnwrappedPose& pose_2,
                        const Input& u) const;

  /// The derivatives of `predict` by both poses; they depend on the first heading and on `u`.
  PoseJacobian jacobian(const UnwrappedPose& pose_1, const Input& u) const;

  /// The number of this model's steps in a time (s), as `model_steps`.
  int steps_in(double time) const;

 private:
  AxisMatrix theta_;
  double dt_;
};

}  // namespace robsim
