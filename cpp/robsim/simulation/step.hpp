#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "robsim/imaging/frame.hpp"
#include "robsim/model/robot_model.hpp"
#include "robsim/vision/locate.hpp"

namespace robsim {

class ParameterEstimator;
class Simulation;

/// Which data the parameters are estimated from.
enum class IdentifyFrom { truth, measurement, estimate };

/// What a state estimator makes of a step.
struct Estimate {
  Pose pose;
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> covariance;
  std::vector<double> state;  // any further state
};

/// One sample for the parameter estimator: that of step k.
struct Sample {
  Regression regression;
  std::int64_t k = 0;
};

/// What the robot half may know of a step. It fills up from stage to stage.
struct Step {
  std::int64_t k = 0;
  double t = 0;   // s
  double dt = 0;  // s
  Input last_u;   // the input of step k-1
  std::optional<Sample> sample;
  std::optional<AxisMatrix> parameters;
  std::optional<Frame> frame;
  std::optional<BlobsByColor> blobs;
  std::optional<Measurement> measurement;
  std::optional<Estimate> estimate;
  std::optional<Input> u;  // the input of this step, as sent
  std::shared_ptr<ParameterEstimator> estimator;
  MarkerLayout markers;
  std::uint64_t controller_seed = 0;

  // The loop this is the newest step of: it can still draw its frame and find its blobs.
  std::atomic<Simulation*> source{nullptr};

  /// Empties what fills up from stage to stage.
  void forget() {
    sample.reset();
    parameters.reset();
    frame.reset();
    blobs.reset();
    measurement.reset();
    estimate.reset();
    u.reset();
  }
};

/// What a robot model gets to compute the pose of step k.
struct WorldState {
  std::int64_t k = 0;
  double t = 0;   // s
  double dt = 0;  // s
  Pose pose_1;    // of step k-1
  Pose pose_2;    // of step k-2
  Input last_u;   // of step k-1
  RobotModel model;
};

}  // namespace robsim
