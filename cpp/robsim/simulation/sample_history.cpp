#include "robsim/simulation/sample_history.hpp"

#include <cmath>

namespace robsim {

void SampleHistory::reset() { *this = SampleHistory(identify_from_); }

void SampleHistory::begin(const Step& step, const RobotModel& model,
                          const std::optional<Input>& last_u, bool is_interrupted) {
  const bool is_exact = step.dt == model.dt();
  const std::int64_t n = is_exact ? 1 : std::llround(step.dt / model.dt());
  follows_ = n == 1 && !is_interrupted;
  if (step.k > 0 && !is_interrupted) {
    time_ += step.dt;
    n_steps_ += n;
  }
  if (last_u) past_[0].u = *last_u;
}

void SampleHistory::check_interval(const Step& step, const RobotModel& model) const {
  if (step.dt == model.dt()) return;
  model.steps_in(step.dt);
  check_mean_interval(time_, n_steps_, model.dt());
}

std::optional<Sample> SampleHistory::newest(std::int64_t k, const Truth* truth) const {
  const bool from_truth = identify_from_ == IdentifyFrom::truth;
  if (from_truth && !truth) return std::nullopt;
  const Past present{from_truth ? std::optional(truth->pose) : std::nullopt,
                     !follows_ || (truth && truth->bounced),
                     {}};
  const Past& now = from_truth ? present : past_[0];
  const Past& last = from_truth ? past_[0] : past_[1];
  const Past& before = from_truth ? past_[1] : past_[2];
  if (!now.pose || !last.pose || !before.pose || now.is_first || last.is_first) return std::nullopt;
  return Sample{regression(*now.pose, *last.pose, *before.pose, last.u), k - (from_truth ? 0 : 1)};
}

void SampleHistory::add(const Step& step, const Truth* truth) {
  past_[2] = past_[1];
  past_[1] = past_[0];
  past_[0] = {pose_of(step, truth), !follows_ || (truth && truth->bounced),
              step.u.value_or(Input{})};
}

std::optional<Pose> SampleHistory::pose_of(const Step& step, const Truth* truth) const {
  switch (identify_from_) {
    case IdentifyFrom::truth:
      if (truth) return truth->pose;
      break;
    case IdentifyFrom::measurement:
      if (step.measurement) return step.measurement->pose;
      break;
    case IdentifyFrom::estimate:
      if (step.estimate) return step.estimate->pose;
      break;
  }
  return std::nullopt;
}

}  // namespace robsim
