#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "robsim/simulation/robot/doubts.hpp"
#include "robsim/simulation/robot/stages.hpp"

namespace robsim {

struct RobotOptions {
  std::vector<ColorClass> colors;
  MarkerLayout markers;          // of the default measurement
  std::optional<int> smoothing;  // px; otherwise as the markers need it
  std::uint64_t controller_seed = 0;
  Given given = Given::all;
  bool gives_samples = true;
};

/// The steps of a run in which the default measurement detected no robot, for the same reason.
struct MissedDetections {
  std::int64_t steps = 0;
  std::int64_t first_k = 0;
  Detection first;  // that of the first of these steps
};

/// The robot half: its stages, and what it knows of the newest step. It needs no world of ours:
/// what it is given is an observation and a camera.
class RobotSoftware {
 public:
  RobotSoftware(const RobotOptions& options, std::shared_ptr<const RunGuard> guard);
  RobotSoftware(const RobotSoftware&) = delete;
  RobotSoftware& operator=(const RobotSoftware&) = delete;

  Stages& stages() { return stages_; }
  const Stages& stages() const { return stages_; }
  MarkerVision& vision() const { return *vision_; }

  /// Looks for other markers, in other colours, from the next step on.
  void set_vision(const std::vector<ColorClass>& colors, const MarkerLayout& markers,
                  std::optional<int> smoothing);
  void set_controller_seed(std::uint64_t seed) { options_.controller_seed = seed; }

  /// Says what callbacks may look at, from the next step on.
  void set_given(Given given, bool samples) {
    options_.given = given;
    options_.gives_samples = samples;
  }

  /// Says of a step that is over whether somebody outside still holds it; otherwise its memory is
  /// used for the next one.
  void set_is_kept(std::function<bool(const StepPointer&)> is_kept) { is_kept_ = is_kept; }

  /// Does what comes once, at the start.
  void start();
  bool has_started() const { return model_.has_value(); }
  void reset();

  /// Begins step k with what came over the seam.
  void begin_step(std::int64_t k, double dt, const Observation& observation,
                  const std::shared_ptr<Camera>& camera);

  // The stages. A measurement or a sample that came over the seam stands: only a callback measures
  // again.
  void estimate_parameters();
  void measure();
  void estimate_state();
  void control();

  /// The model that the robot half believes in, and what identifies it. Only after the start.
  const RobotModel& model() const { return model_.value(); }
  const std::shared_ptr<ParameterEstimator>& estimator() const { return estimator_; }

  /// True if nobody else has the estimator or, with the step, a way to it.
  bool has_estimator_alone() const;

  /// Gives the estimator to the run of this thread, for the life of what it returns. Throws
  /// std::runtime_error if a run in another thread has it. Only after the start.
  std::optional<ThreadGuard::Run> hold_estimator() const;

  /// The newest step. Only after the start.
  const StepPointer& step() const { return step_; }

  /// The last pose that was measured; none while nothing measures.
  std::optional<Pose> held() const;

  /// Why the default measurement detected no robot, since the start.
  const std::map<DetectionResult, MissedDetections>& missed() const { return missed_; }

  /// Implausible results of stages since the start, in words.
  std::vector<std::string> doubts() const { return doubts_.texts(); }

  /// Says what was sent to the robot: the last_u of the next step.
  void set_last_input(const Input& u) { last_u_ = u; }

  /// True if a stage needs the interpreter.
  bool is_interpreted() const;

 private:
  void renew_step();
  void count_missed(const Detection& detection);

  RobotOptions options_;
  std::shared_ptr<const RunGuard> guard_;
  std::shared_ptr<MarkerVision> vision_;
  Stages stages_;
  std::function<bool(const StepPointer&)> is_kept_;

  std::optional<RobotModel> model_;
  std::shared_ptr<ParameterEstimator> estimator_;
  StepPointer step_;
  Input last_u_;
  std::optional<Pose> held_;
  std::map<DetectionResult, MissedDetections> missed_;
  Doubts doubts_;
  std::size_t state_size_ = 0;  // further numbers of the state estimator
};

}  // namespace robsim
