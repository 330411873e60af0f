#pragma once

#include <array>
#include <memory>
#include <optional>
#include <utility>

#include "robsim/simulation/seam/observation.hpp"
#include "robsim/simulation/seam/thread_guard.hpp"

namespace robsim {

/// What only a simulated world knows of a step.
struct Truth {
  std::int64_t k = 0;
  Pose pose;
  bool bounced = false;
  bool hidden = false;               // from the camera
  Point view;                        // displacement of the camera's view, work-area px
  std::array<double, 2> noise = {};  // of the camera: VisualNoise::Percent
  KnownTurn turn;                    // of the heading of the step before
};

/// What became of an input.
struct Sent {
  Input u;                  // as it was sent
  std::optional<double> t;  // s, by the clock of the frames: when it was
};

/// What comes when the world half is asked for the next step.
enum class Arrival { step, nothing_yet, end };

/// The world half: simulated, recorded, live or in another process.
class World : public Camera {
 public:
  /// The guard of the loop that the world belongs to.
  void set_guard(std::shared_ptr<const RunGuard> guard) { guard_ = std::move(guard); }

  /// Called once, before the first step, with the model that the robot half believes in.
  virtual void start(const RobotModel& model) = 0;

  /// Back to the start.
  virtual void reset() = 0;

  /// The next step, with what the robot half may know of it. `nothing_yet` after a short while
  /// without: the loop asks again.
  virtual Arrival next(std::int64_t k, Observation& observation) = 0;

  /// Takes the input of step k, the moment that it is decided.
  virtual Sent send(std::int64_t k, const Input& u) = 0;

  /// Stops the robot, if somebody has to, and returns the input that did: at the end of a run,
  /// whatever ended it, and at a reset.
  virtual std::optional<Input> stop() noexcept { return std::nullopt; }

  /// True if the robot was stopped already, without a call of `stop`.
  virtual bool was_stopped() const { return false; }

  /// True if the robot answered before, and no longer does.
  virtual bool is_robot_silent() const { return false; }

  /// True if its frames do not wait for anybody: a step that was broken off cannot go on later.
  virtual bool is_live() const { return false; }

  /// The truth of the newest step, null if nobody knows it.
  virtual const Truth* truth() const { return nullptr; }

  /// True if the camera's view moves over the work area.
  virtual bool has_moving_view() const { return false; }

  /// True if it needs the interpreter.
  virtual bool is_interpreted() const = 0;

 protected:
  const RunGuard& guard() const { return *guard_; }

 private:
  std::shared_ptr<const RunGuard> guard_ = std::make_shared<RunGuard>();
};

}  // namespace robsim
