#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "robsim/simulation/stages.hpp"
#include "robsim/simulation/trace.hpp"
#include "robsim/vision/marker_blobs.hpp"
#include "robsim/world/noise/visual_noise.hpp"
#include "robsim/world/work_area.hpp"

namespace robsim {

/// Something hides the robot from the camera: with this probability throughout each segment of so
/// many steps.
struct Dropout {
  double probability = 0;
  int steps = 1;
  std::uint64_t seed = 0;

  bool hides(std::int64_t k) const;
};

struct SimulationOptions {
  WorkArea area;
  double robot_radius = 0;  // of the robot's outline around its centre, work-area px
  Pose start;
  VisualNoise noise;
  std::vector<ColorClass> colors;
  MarkerLayout markers;          // of the default measurement
  std::optional<int> smoothing;  // px; otherwise as the markers need it
  IdentifyFrom identify_from = IdentifyFrom::truth;
  std::uint64_t controller_seed = 0;
  std::uint64_t noise_seed = 0;
  Dropout dropout;
};

/// The loop: the world half makes a frame of every step, the robot half answers with an input.
class Simulation {
 public:
  Simulation(SimulationOptions options, Stages stages);
  virtual ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  const SimulationOptions& options() const { return options_; }

  /// The stages, to be changed between two runs. Throws std::runtime_error during a run.
  Stages& stages();

  /// Does what comes once, at the start, if that has not been done yet.
  void start();

  /// So many turns of the loop, or until there are no more frames. A stage that throws ends the
  /// run; the trace up to the step before is kept, and the next run goes on with the stage that
  /// threw.
  /// Throws std::runtime_error when it is already running.
  void run(std::int64_t steps, Interpreter& interpreter);

  /// Back to the start: the next run begins anew and gives the same again.
  void reset();

  bool has_started() const { return model_.has_value(); }
  bool is_running() const { return running_; }
  std::int64_t next_step() const { return trace_.rows(); }
  const Trace& trace() const { return trace_; }
  const RobotModel& model() const { return model_.value(); }
  const std::shared_ptr<ParameterEstimator>& estimator() const { return estimator_; }

  /// The newest step. Only after the start.
  const StepPointer& last_step() const;

  /// True if somebody outside the loop still holds a step that is over: then its memory is not used
  /// for the next one.
  virtual bool is_kept(const StepPointer& step) const;

  /// Throws std::runtime_error while another thread runs the simulation.
  void check_thread() const;

  /// The newest frame, and what is in it, drawn and found when first asked for. Only after the
  /// start. Throws std::runtime_error while another thread runs the simulation.
  const Frame& frame();
  const BlobsByColor& blobs();

  /// How blobs are found in the newest frame.
  const BlobOptions& blob_options() const { return finder_.options(); }

  /// The frame of a recorded step, drawn anew. Throws std::out_of_range if there is no such step,
  /// std::runtime_error if the world is not simulated.
  Frame render_step(std::int64_t k);

 private:
  // What is remembered of a step for the samples of the next ones.
  struct Past {
    std::optional<Pose> pose;  // as identify_from says
    bool bounced = false;
    Input u;
  };

  // Where the trace keeps what; null = not recorded.
  struct Columns {
    Trace::Column* t = nullptr;
    Trace::Column* pose_true = nullptr;
    Trace::Column* u = nullptr;
    Trace::Column* bounced = nullptr;
    Trace::Column* measured = nullptr;
    Trace::Column* held = nullptr;
    Trace::Column* parameters = nullptr;
    Trace::Column* standard_errors_unscaled = nullptr;
    Trace::Column* estimated = nullptr;
    Trace::Column* covariance = nullptr;
    Trace::Column* view = nullptr;
    std::vector<Trace::Column*> blobs;  // in the order of the colours' names
  };

  class Busy;
  class NativeWork;

  void prepare();
  bool is_simulated() const { return !stages_.take_frame; }
  bool turn();
  bool take_frame();
  void move_robot();
  void estimate_parameters();
  void measure();
  void estimate_state();
  void control();
  void record();

  WorldState world_state(std::int64_t k) const;
  void move_view();
  void suit_finder(const Frame& frame);
  Frame draw_frame(std::int64_t k, double t, const Pose& pose, const Pan& pan);
  void begin_step();
  std::optional<Sample> newest_sample() const;
  void add_columns();
  void record_measurement();
  void record_estimate();
  bool needs_interpreter() const;

  SimulationOptions options_;
  Stages stages_;
  BlobFinder finder_;

  // Made at the start.
  std::optional<RobotModel> model_;
  std::shared_ptr<ParameterEstimator> estimator_;
  std::optional<Renderer> renderer_;
  ImagePool noisy_images_;

  // The world: the last two poses; bounces mirror them together.
  Pose pose_;
  Pose last_pose_;
  bool bounced_ = false;
  Pan pan_;

  // The robot half.
  StepPointer step_;
  Input input_;
  std::optional<Pose> held_;
  std::optional<AxisMatrix> parameters_;
  std::array<Past, 3> past_;  // the newest first

  bool has_begun_ = false;  // the turn: the robot has moved, or the frame was taken
  std::size_t next_stage_ = 0;
  Trace trace_;
  Columns columns_;
  Interpreter* interpreter_ = nullptr;  // while it is held
  std::atomic<bool> running_{false};
  std::atomic<std::thread::id> runner_{};
};

}  // namespace robsim
