#include "robsim/simulation/sample_history.hpp"

#include <cmath>

namespace robsim {

namespace {

constexpr int most_off_beat = 10;  // steps; if there are more, the camera has another rate

}  // namespace

void SampleHistory::reset() { *this = SampleHistory(identify_from_); }

void SampleHistory::begin(const Step& step, const RobotModel& model,
                          const std::optional<Input>& last_u, bool is_interrupted, bool is_live) {
  const bool is_exact = step.dt == model.dt();
  const std::int64_t n = is_exact ? 1 : std::llround(step.dt / model.dt());
  off_beat_ = is_live && !is_exact && !is_multiple(step.dt, model.dt()) ? off_beat_ + 1 : 0;
  follows_ = n == 1 && !is_interrupted && off_beat_ == 0;
  if (step.k > 0 && !is_interrupted && off_beat_ == 0) {
    time_ += step.dt;
    n_steps_ += n;
  }
  if (last_u) past(0).u = *last_u;
}

void SampleHistory::check_interval(const Step& step, const RobotModel& model) const {
  if (step.dt == model.dt() || (off_beat_ > 0 && off_beat_ < most_off_beat)) return;
  model.steps_in(step.dt);
  check_mean_interval(time_, n_steps_, model.dt());
}

void SampleHistory::write_newest(Step& step, const Truth* truth) const {
  const bool from_truth = identify_from_ == IdentifyFrom::truth;
  if (step.has_sample() || (from_truth && !truth)) return;
  const std::size_t newest = k_ < step.k ? 0 : 1;  // of the steps before this one
  const Past& last = past(from_truth ? newest : newest + 1);
  const Past& before = past(from_truth ? newest + 1 : newest + 2);
  const Pose* const now = from_truth ? &truth->pose : past(newest).seen();
  const bool is_first = from_truth ? !follows_ || truth->bounced : past(newest).is_first;
  if (!now || !last.has_pose || !before.has_pose || is_first || last.is_first) return;
  Moves& moves = step.moves.emplace();  // in its place: a copy would wait for the writes
  moves.pose = *now;
  moves.pose_1 = last.pose;
  moves.pose_2 = before.pose;
  moves.u = last.u;
  moves.k = step.k - (from_truth ? 0 : 1);
  if (from_truth && newest == 0) moves.turn = truth->turn;
}

void SampleHistory::add(const Step& step, const Truth* truth) {
  k_ = step.k;
  newest_ = (newest_ + past_.size() - 1) % past_.size();
  Past& newest = past(0);
  const Pose* const pose = pose_of(step, truth);
  newest.has_pose = pose != nullptr;
  if (pose) newest.pose = *pose;
  newest.is_first = !follows_ || (truth && truth->bounced);
  newest.u = step.u ? *step.u : Input{};
}

const Pose* SampleHistory::pose_of(const Step& step, const Truth* truth) const {
  switch (identify_from_) {
    case IdentifyFrom::truth:
      return truth ? &truth->pose : nullptr;
    case IdentifyFrom::measurement:
      return step.measurement ? &step.measurement->pose : nullptr;
    case IdentifyFrom::estimate:
      return step.estimate ? &step.estimate->pose : nullptr;
  }
  return nullptr;
}

}  // namespace robsim
