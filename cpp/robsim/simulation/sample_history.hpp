#pragma once

#include <array>
#include <optional>

#include "robsim/simulation/robot/step.hpp"
#include "robsim/simulation/seam/world.hpp"

namespace robsim {

/// Which data the parameters are estimated from.
enum class IdentifyFrom { truth, measurement, estimate };

/// Makes the samples for the parameter estimator of the last three poses. A pose that is missing, a
/// bounce, a gap in time and an input that others gave interrupt the record.
class SampleHistory {
 public:
  explicit SampleHistory(IdentifyFrom identify_from) : identify_from_(identify_from) {}

  void reset();

  /// Begins a step of a model; `last_u` is the input since the last one, if others know it better.
  /// `is_interrupted`: the robot was stopped since the last one. `is_live`: a frame that came at
  /// another time than its turn interrupts the record, and is no error.
  void begin(const Step& step, const RobotModel& model, const std::optional<Input>& last_u,
             bool is_interrupted, bool is_live);

  /// Gives the newest step, before or after its end, the newest complete sample, unless it has one:
  /// from truth of this step, otherwise of the previous one.
  void write_newest(Step& step, const Truth* truth) const;

  /// Throws std::invalid_argument if the steps are not those of the model: live, if that goes on.
  void check_interval(const Step& step, const RobotModel& model) const;

  /// Ends a step.
  void add(const Step& step, const Truth* truth);

 private:
  // What is remembered of a step for the samples of the next ones.
  struct Past {
    Pose pose;
    bool has_pose = false;
    bool is_first = false;  // of a record: it does not follow from the step before
    Input u;

    const Pose* seen() const { return has_pose ? &pose : nullptr; }
  };

  const Pose* pose_of(const Step& step, const Truth* truth) const;

  Past& past(std::size_t age) { return past_[(newest_ + age) % past_.size()]; }
  const Past& past(std::size_t age) const { return past_[(newest_ + age) % past_.size()]; }

  IdentifyFrom identify_from_;
  std::array<Past, 4> past_;  // a ring, older and older from the newest on
  std::size_t newest_ = 0;
  std::int64_t k_ = -1;       // of the step that was added last
  bool follows_ = true;       // this step does from the one before
  int off_beat_ = 0;          // steps up to this one that came at another time than their turn
  double time_ = 0;           // s, of all steps
  std::int64_t n_steps_ = 0;  // of the model, in that time
};

}  // namespace robsim
