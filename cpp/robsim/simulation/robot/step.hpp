#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "robsim/imaging/plane_map.hpp"
#include "robsim/simulation/seam/observation.hpp"
#include "robsim/simulation/seam/thread_guard.hpp"
#include "robsim/vision/marker_vision.hpp"

namespace robsim {

class ParameterEstimator;

/// What a state estimator makes of a step.
struct Estimate {
  Pose pose;
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> covariance;
  std::vector<double> state;  // any further state
};

/// What callbacks may look at: that of a robot half here, or what one elsewhere would be told.
/// Native stages look at all.
enum class Given {
  all,
  frames,  // frame and blobs, but not how the default measurement has found what it found
  blobs,
  pose,  // the measurement alone
};

/// The poses and the input of the newest sample.
struct Moves {
  Pose pose, pose_1, pose_2;  // of steps k, k-1 and k-2
  Input u;                    // of step k-1
  std::int64_t k = 0;
  KnownTurn turn;  // of pose_1
};

/// A frame, and the detection in it.
struct Sight {
  Frame frame;
  std::optional<BlobsByColor> blobs;
  std::optional<Detection> detection;
};

/// What the robot half may know of a step. It fills up from stage to stage.
struct Step {
  /// `marker_vision` may be missing: such a step has no markers.
  Step(std::shared_ptr<const RunGuard> run_guard, std::shared_ptr<MarkerVision> marker_vision)
      : guard(std::move(run_guard)), vision(std::move(marker_vision)) {}

  std::int64_t k = 0;
  double t = 0;                          // s
  double dt = 0;                         // s
  Input last_u;                          // the input of step k-1
  std::optional<Moves> moves;            // instead of a sample
  std::optional<AxisMatrix> parameters;  // the newest ones, if there are any
  std::optional<Measurement> measurement;
  std::optional<Detection> detection;  // of the default measurement
  std::optional<Estimate> estimate;
  std::optional<Input> u;  // the input of this step, as sent
  std::shared_ptr<ParameterEstimator> estimator;
  std::uint64_t controller_seed = 0;
  Given given = Given::all;
  bool gives_sample = true;

  bool has_frame = true;  // one has come
  std::optional<Frame> frame;
  std::optional<BlobsByColor> blobs;
  std::shared_ptr<const Sight> known;  // from another run, which saw the same frame

  /// The frame, made when first asked for; null if none has come. Throws std::runtime_error if the
  /// step is over and nobody looked.
  const Frame* look();

  /// The blobs in it, found when first asked for: none without a frame.
  const BlobsByColor& find_blobs();

  /// As look and find_blobs, for callbacks. Throw std::runtime_error where these are not given.
  const Frame* given_frame();
  const BlobsByColor& given_blobs();

  /// The newest complete sample, if there is one.
  const std::optional<Sample>& find_sample();
  void set_sample(const std::optional<Sample>& sample) { sample_ = sample; }
  bool has_sample() const { return sample_ || moves; }

  /// The default measurement: looks for the markers in the frame, and keeps the detection.
  std::optional<Measurement> detect();

  /// Whether `look` still finds a frame, or knows that none has come.
  bool can_look() const { return frame || camera || !has_frame; }

  /// Throw std::runtime_error for a step made without markers.
  const MarkerLayout& markers() const;
  const std::vector<ColorClass>& colors() const;

  const MarkerVision* marker_vision() const { return vision.get(); }

  /// Throws std::runtime_error while another thread fills the step.
  void check_thread() const;

  /// Empties what fills up from stage to stage, for the next step.
  void begin(const std::shared_ptr<Camera>& the_camera);

  /// The step is over: what nobody looked at is gone.
  void end();

 private:
  Camera& open_camera(const char* what) const;
  MarkerVision& open_vision() const;

  const std::shared_ptr<const RunGuard> guard;
  const std::shared_ptr<MarkerVision> vision;
  std::shared_ptr<Camera> camera;
  std::optional<Sample> sample_;
  std::atomic<bool> is_over{false};
};

using StepPointer = std::shared_ptr<Step>;

}  // namespace robsim
