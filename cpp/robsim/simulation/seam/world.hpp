#pragma once

#include "robsim/simulation/seam/observation.hpp"
#include "robsim/world/noise/visual_noise.hpp"

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
  /// Called once, at the start of a run, with the model that the robot half believes in.
  virtual void start(const RobotModel& model) = 0;

  /// Back to the start.
  virtual void reset() = 0;

  /// The next step, with what the robot half may know of it. `nothing_yet` after a short while
  /// without: the loop asks again.
  virtual Arrival next(std::int64_t k, Observation& observation) = 0;

  /// Takes the input of step k, the moment that it is decided.
  virtual void send(std::int64_t k, const Input& u) = 0;

  /// Called when a run is over, whatever ended it: stops the robot, if somebody has to, and returns
  /// the input that did.
  virtual std::optional<Input> stop() noexcept { return std::nullopt; }

  /// The truth of the newest step, null if nobody knows it.
  virtual const Truth* truth() const { return nullptr; }

  /// True if the camera's view moves over the work area.
  virtual bool has_moving_view() const { return false; }

  /// True if it needs the interpreter.
  virtual bool is_interpreted() const = 0;
};

}  // namespace robsim
