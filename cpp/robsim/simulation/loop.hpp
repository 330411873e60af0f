#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>

#include "robsim/simulation/recorder.hpp"
#include "robsim/simulation/robot/robot_software.hpp"
#include "robsim/simulation/sample_history.hpp"
#include "robsim/simulation/seam/world.hpp"
#include "robsim/simulation/sights.hpp"

namespace robsim {

/// A turn of the loop, part by part: the manual's five stages, and the input goes out.
enum class Stage { world, estimate_parameters, measure, estimate_state, control, send };

/// Joins the two halves: what the world shows goes to the robot half, its input goes back; what
/// both know is recorded.
class Loop {
 public:
  /// Called every 50 ms or so, between two steps; in a live run without the interpreter, beside
  /// them. May throw, which ends the run.
  using Pulse = std::function<void(std::int64_t done)>;

  /// What became of a step, for who keeps a record of his own. Must not throw.
  struct Outcome {
    const StepPointer& step;
    std::optional<double> t_arrival, t_sent;  // s, by the clock of the frames
    bool interrupted;                         // the robot was stopped since the step before
  };
  using Observer = std::function<void(const Outcome&)>;

  Loop(std::shared_ptr<World> world, const RobotOptions& robot, IdentifyFrom identify_from);

  RobotSoftware& robot() { return robot_; }
  const RobotSoftware& robot() const { return robot_; }
  const Trace& trace() const { return recorder_.trace(); }

  /// The slots, to be filled between two runs. Throws std::runtime_error during a run.
  Stages& stages();

  /// Says who is told of each step when it is over. Throws std::runtime_error during a run.
  void set_observer(Observer observer);

  /// The next runs take known frames and detections from there, and add theirs. Throws
  /// std::runtime_error during a run.
  void share(std::shared_ptr<Sights> sights);

  /// Does what comes once, at the start, if that has not been done yet.
  void start();

  /// So many turns, or until the world ends or somebody stops the run. A stage that throws ends the
  /// run; what was recorded is kept, and the next run goes on with the stage that threw. True if
  /// the world has come to its end. `stops_robot`: also where nothing but the number of steps ends
  /// it. Throws std::runtime_error when it is running already.
  bool run(std::int64_t steps, const Pulse& pulse, bool stops_robot);

  /// The next stage that is on; nothing at the end of the world. Throws std::runtime_error if it
  /// is stopped before a frame has come.
  std::optional<Stage> step_stage(const Pulse& pulse);

  /// Ends the run under way between two steps; from any thread. False if there is none.
  bool stop() { return guard_->stop(); }

  /// Stops the robot, if somebody has to: between two runs.
  void stop_robot_between_runs();

  /// Back to the start, with the robot stopped: the next run begins anew and gives the same again.
  void reset();

  bool has_started() const { return robot_.has_started(); }
  const RunGuard& guard() const { return *guard_; }

  /// The newest step. Throws std::runtime_error before the start, and while another thread runs.
  const StepPointer& last_step() const;

  /// The stage that runs now, or that comes next; from any thread.
  Stage stage() const { return stage_; }

 private:
  void prepare();
  void stop_robot();
  void resume();
  bool turns(std::int64_t steps, const Pulse& pulse, bool stops_robot);
  bool turns_beside(std::int64_t steps, const Pulse& pulse, bool stops_robot);
  bool turn_on(std::int64_t steps, const Pulse& pulse);
  Arrival turn();
  Arrival do_stage();
  Arrival begin_step();
  void estimate_parameters();
  void write_sample();
  void end_step();
  void keep_step(const std::optional<double>& t_sent);
  bool is_on(Stage stage) const;
  bool is_interpreted() const {
    return world_->is_interpreted() || robot_.is_interpreted() || observer_;
  }

  std::shared_ptr<RunGuard> guard_;
  std::shared_ptr<World> world_;
  std::shared_ptr<Camera> camera_;  // of the world
  RobotSoftware robot_;
  SampleHistory samples_;
  Recorder recorder_;
  Observer observer_;
  std::shared_ptr<Sights> sights_;
  bool has_witness_ = true;      // a callback may look at each step
  bool is_interrupted_ = false;  // the robot was stopped since the newest step began
  Observation observation_;      // of the newest step
  bool follows_stop_ = false;    // the newest step began after that
  std::atomic<Stage> stage_{Stage::world};
};

}  // namespace robsim
