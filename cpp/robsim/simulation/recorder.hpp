#pragma once

#include <vector>

#include "robsim/simulation/robot/robot_software.hpp"
#include "robsim/simulation/seam/world.hpp"
#include "robsim/simulation/trace.hpp"

namespace robsim {

/// Writes what is known of each step into a trace.
class Recorder {
 public:
  const Trace& trace() const { return trace_; }
  std::int64_t rows() const { return trace_.rows(); }

  /// Makes room for so many rows more, and the columns of what is to come.
  void prepare(const World& world, const RobotSoftware& robot, std::int64_t steps);

  /// Writes the newest step, with what came over the seam at it. `t_sent`: when its input went out,
  /// if that is known (s). `interrupted`: the robot was stopped since the step before.
  void record(const World& world, const RobotSoftware& robot, const Observation& observation,
              const std::optional<double>& t_sent, bool interrupted);

  /// Forgets everything.
  void reset();

 private:
  // Where the trace keeps what; null = not recorded.
  struct Columns {
    Trace::Column* t = nullptr;
    Trace::Column* pose_true = nullptr;
    Trace::Column* u = nullptr;
    Trace::Column* bounced = nullptr;
    Trace::Column* measured = nullptr;
    Trace::Column* held = nullptr;
    Trace::Column* covariance_measured = nullptr;
    Trace::Column* misfit = nullptr;
    Trace::Column* signal_to_noise = nullptr;
    Trace::Column* missed = nullptr;
    Trace::Column* parameters = nullptr;
    Trace::Column* standard_errors_unscaled = nullptr;
    Trace::Column* estimated = nullptr;
    Trace::Column* covariance = nullptr;
    Trace::Column* view = nullptr;
    std::vector<Trace::Column*> blobs;  // in the order of the colours' names
  };

  void write_input(Trace::Column& column, const Input& u);
  void prepare_measurement(const RobotSoftware& robot);
  void record_truth(const Truth& truth);
  void record_parameters(const RobotSoftware& robot);
  void record_measurement(const Step& step, const std::optional<Pose>& held);
  void record_quality(const Measurement& measurement);
  void record_estimate(const Step& step);

  // One that is made when there is something to write.
  Trace::Column& column(Trace::Column*& known, const char* name);

  Trace trace_;
  Columns columns_;
};

}  // namespace robsim
