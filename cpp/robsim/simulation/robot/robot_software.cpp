#include "robsim/simulation/robot/robot_software.hpp"

#include <string>
#include <utility>

namespace robsim {

RobotSoftware::RobotSoftware(const RobotOptions& options, std::shared_ptr<const RunGuard> guard)
    : options_(options),
      guard_(std::move(guard)),
      vision_(std::make_shared<MarkerVision>(options.colors, options.markers, options.smoothing)),
      is_kept_([](const StepPointer& step) { return step.use_count() > 1; }) {}

void RobotSoftware::set_vision(const std::vector<ColorClass>& colors, const MarkerLayout& markers,
                               std::optional<int> smoothing) {
  vision_ = std::make_shared<MarkerVision>(colors, markers, smoothing);
}

void RobotSoftware::start() {
  RobotModel model = stages_.define_model();
  estimator_ = stages_.init_parameter_estimator(model);
  const auto& update = stages_.estimate_parameters;
  if (update && !update.is_interpreted) estimator_->check();
  last_u_ = {};
  held_.reset();
  missed_.clear();
  doubts_.clear();
  state_size_ = 0;
  model_ = std::move(model);
}

void RobotSoftware::reset() {
  if (step_) step_->end();
  step_.reset();
  model_.reset();
  estimator_.reset();
}

void RobotSoftware::begin_step(std::int64_t k, double dt, const Observation& observation,
                               const std::shared_ptr<Camera>& camera) {
  renew_step();
  step_->begin(camera);
  step_->k = k;
  step_->t = observation.t;
  step_->dt = dt;
  step_->last_u = observation.last_u.value_or(last_u_);
  step_->has_frame = observation.has_frame;
  if (observation.sample) step_->set_sample(observation.sample);
  step_->measurement = observation.measurement;
  if (step_->estimator != estimator_) step_->estimator = estimator_;
  step_->controller_seed = options_.controller_seed;
  step_->given = options_.given;
  step_->gives_sample = options_.gives_samples;
}

void RobotSoftware::renew_step() {
  if (step_ && !is_kept_(step_) && step_->marker_vision() == vision_.get()) return;
  const StepPointer last = std::exchange(step_, std::make_shared<Step>(guard_, vision_));
  if (!last) return;
  last->end();
  step_->parameters = last->parameters;
}

bool RobotSoftware::has_estimator_alone() const {
  const bool has_step = step_ && step_->estimator == estimator_;
  return estimator_.use_count() == (has_step ? 2 : 1) && (!has_step || step_.use_count() == 1);
}

std::optional<ThreadGuard::Run> RobotSoftware::hold_estimator() const {
  const ThreadGuard* guard = estimator_ ? estimator_->guard() : nullptr;
  return guard ? std::optional<ThreadGuard::Run>(std::in_place, *guard) : std::nullopt;
}

void RobotSoftware::estimate_parameters() {
  if (!stages_.estimate_parameters) return;
  if (const auto result = stages_.estimate_parameters.call(step_)) step_->parameters = *result;
}

void RobotSoftware::measure() {
  const bool is_done = step_->measurement && !stages_.measure.is_interpreted;
  if (stages_.measure && step_->has_frame && !is_done) {
    step_->measurement = stages_.measure.call(step_);
    if (step_->frame) step_->find_blobs();  // of a callback that has looked
    const bool is_ours = step_->measurement && !stages_.measure.is_interpreted;
    if (is_ours && options_.given != Given::all) step_->measurement->pair.reset();
    if (step_->detection && !step_->measurement) count_missed(*step_->detection);
  }
  if (!step_->measurement) return;
  held_ = step_->measurement->pose;
  doubts_.look_at(*step_->measurement, step_->k);
}

std::optional<Pose> RobotSoftware::held() const {
  return stages_.measure || step_->measurement ? held_ : std::nullopt;
}

void RobotSoftware::count_missed(const Detection& detection) {
  MissedDetections& missed = missed_[detection.result];
  if (missed.steps++ > 0) return;
  missed.first_k = step_->k;
  missed.first = detection;
}

void RobotSoftware::estimate_state() {
  if (!stages_.estimate_state) return;
  Estimate estimate = stages_.estimate_state.call(step_);
  const std::size_t size = estimate.state.size();
  if (size > 0 && state_size_ > 0 && size != state_size_) {
    throw ResultError("estimate_state", step_->k,
                      "state must have " + std::to_string(state_size_) +
                          " numbers at every step, got " + std::to_string(size));
  }
  if (size > 0) state_size_ = size;
  doubts_.look_at(estimate, step_->k);
  step_->estimate = std::move(estimate);
}

void RobotSoftware::control() {
  if (!stages_.control) return;
  step_->u = stages_.control.call(step_);
  doubts_.look_at(*step_->u, step_->k);
}

bool RobotSoftware::is_interpreted() const {
  return stages_.estimate_parameters.is_interpreted || stages_.measure.is_interpreted ||
         stages_.estimate_state.is_interpreted || stages_.control.is_interpreted ||
         (stages_.estimate_parameters && estimator_->is_interpreted());
}

}  // namespace robsim
