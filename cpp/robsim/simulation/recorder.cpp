#include "robsim/simulation/recorder.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

namespace robsim {

namespace {

constexpr std::int64_t most_rows_at_once = 1 << 16;  // a longer trace doubles its memory on the way

void write(double* row, const Pose& pose) {
  row[0] = pose.x;
  row[1] = pose.y;
  row[2] = pose.heading;
}

}  // namespace

void Recorder::prepare(const World& world, const RobotSoftware& robot, std::int64_t steps) {
  const bool has_truth = world.truth();
  const Stages& stages = robot.stages();
  if (!has_truth) columns_.t = &trace_.column("t");
  if (has_truth) columns_.pose_true = &trace_.column("pose_true");
  if (stages.control) columns_.u = &trace_.column("u");
  if (has_truth) columns_.bounced = &trace_.column("bounced");
  if (stages.measure || !has_truth) prepare_measurement(robot);
  if (stages.estimate_parameters) {
    columns_.parameters = &trace_.column("parameters");
    if (robot.estimator()->has_standard_errors())
      columns_.standard_errors_unscaled = &trace_.column("standard_errors_unscaled");
  }
  if (stages.estimate_state) {
    columns_.estimated = &trace_.column("pose_estimated");
    columns_.covariance = &trace_.column("covariance");
  }
  if (world.has_moving_view()) columns_.view = &trace_.column("view");
  trace_.reserve(trace_.rows() + std::min(steps, most_rows_at_once));
}

void Recorder::prepare_measurement(const RobotSoftware& robot) {
  columns_.measured = &trace_.column("pose_measured");
  columns_.held = &trace_.column("pose_held");
  if (!robot.stages().measure) return;
  std::set<std::string> names;
  for (const ColorClass& color : robot.vision().colors()) names.insert(color.name);
  columns_.blobs.clear();
  for (const std::string& name : names) {
    columns_.blobs.push_back(&trace_.column("blobs_" + name, 4));
  }
}

void Recorder::write_input(Trace::Column& column, const Input& u) {
  double* numbers = trace_.writable(column);
  numbers[0] = u.u1;
  numbers[1] = u.u2;
}

void Recorder::record(const World& world, const RobotSoftware& robot,
                      const Observation& observation, const std::optional<double>& t_sent,
                      bool interrupted) {
  const Step& step = *robot.step();
  if (const Truth* truth = world.truth()) record_truth(*truth);
  if (columns_.t) *trace_.writable(*columns_.t) = step.t;
  if (observation.t_arrival) *trace_.writable(trace_.column("t_arrival")) = *observation.t_arrival;
  if (t_sent) *trace_.writable(trace_.column("t_sent")) = *t_sent;
  if (step.u) write_input(*columns_.u, *step.u);
  if (observation.last_u) write_input(trace_.column("last_u"), *observation.last_u);
  if (interrupted) *trace_.writable(trace_.column("interrupted")) = 1;
  if (world.is_robot_silent()) *trace_.writable(trace_.column("unanswered")) = 1;
  record_parameters(robot);
  if (step.measurement && !columns_.measured) prepare_measurement(robot);
  record_measurement(step, robot.held());
  record_estimate(step);
  trace_.append();
}

void Recorder::record_truth(const Truth& truth) {
  write(trace_.writable(*columns_.pose_true), truth.pose);
  *trace_.writable(*columns_.bounced) = truth.bounced;
  if (columns_.view) {
    double* view = trace_.writable(*columns_.view);
    view[0] = truth.view.x;
    view[1] = truth.view.y;
  }
  // What is 0 throughout the run takes no column.
  if (truth.hidden) *trace_.writable(trace_.column("hidden")) = 1;
  if (truth.noise != decltype(truth.noise){}) {
    std::copy_n(truth.noise.data(), 2, trace_.writable(trace_.column("noise")));
  }
}

void Recorder::record_parameters(const RobotSoftware& robot) {
  const Step& step = *robot.step();
  if (step.parameters && columns_.parameters) {
    std::copy_n(step.parameters->data(), 15, trace_.writable(*columns_.parameters));
  }
  if (columns_.standard_errors_unscaled) {
    robot.estimator()->write_standard_errors_unscaled(
        trace_.writable(*columns_.standard_errors_unscaled));
  }
}

void Recorder::record_measurement(const Step& step, const std::optional<Pose>& held) {
  if (step.measurement) {
    write(trace_.writable(*columns_.measured), step.measurement->pose);
    record_quality(*step.measurement);
  } else if (step.detection) {
    *trace_.writable(column(columns_.missed, "missed")) =
        static_cast<double>(step.detection->result);
  }
  if (held && columns_.held) write(trace_.writable(*columns_.held), *held);
  if (!step.blobs || !step.frame || columns_.blobs.empty()) return;
  auto column = columns_.blobs.begin();
  for (const auto& [color, blobs] : *step.blobs) {
    double* positions = trace_.writable(**column++);
    for (std::size_t i = 0; i < std::min<std::size_t>(2, blobs.size()); ++i) {
      const Point position = step.frame->plane_map.to_world(blobs[i].centroid);
      positions[2 * i] = position.x;
      positions[2 * i + 1] = position.y;
    }
  }
}

// What nobody says of any measurement takes no column.
void Recorder::record_quality(const Measurement& measurement) {
  if (measurement.covariance) {
    double* numbers = trace_.writable(column(columns_.covariance_measured, "covariance_measured"));
    std::copy_n(measurement.covariance->data(), 9, numbers);
  }
  if (!std::isnan(measurement.misfit)) {
    *trace_.writable(column(columns_.misfit, "misfit")) = measurement.misfit;
  }
  if (!std::isnan(measurement.signal_to_noise)) {
    *trace_.writable(column(columns_.signal_to_noise, "signal_to_noise")) =
        measurement.signal_to_noise;
  }
}

Trace::Column& Recorder::column(Trace::Column*& known, const char* name) {
  if (!known) known = &trace_.column(name);
  return *known;
}

void Recorder::record_estimate(const Step& step) {
  if (!step.estimate) return;
  const Estimate& estimate = *step.estimate;
  write(trace_.writable(*columns_.estimated), estimate.pose);
  std::copy_n(estimate.covariance.data(), 9, trace_.writable(*columns_.covariance));
  if (estimate.state.empty()) return;
  double* state = trace_.writable(trace_.column("state", estimate.state.size()));
  std::copy(estimate.state.begin(), estimate.state.end(), state);
}

void Recorder::reset() {
  trace_.clear();
  columns_ = {};
}

}  // namespace robsim
