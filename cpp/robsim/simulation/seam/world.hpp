#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "robsim/simulation/seam/observation.hpp"
#include "robsim/simulation/seam/run_guard.hpp"

namespace robsim {

/// What only a simulated world knows of a step.
struct Truth {
  Pose pose;
  bool bounced = false;
  Point view;                 // by which the camera's view is displaced, work-area px
  bool hidden = false;        // from the camera
  double gaussian_noise = 0;  // %
  double uniform_noise = 0;   // %
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
  virtual void send(std::int64_t k, const Input& u) = 0;

  /// Stops the robot, if somebody has to, and returns the input that did: at the end of a run,
  /// whatever ended it, and at a reset.
  virtual std::optional<Input> stop() noexcept { return std::nullopt; }

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
