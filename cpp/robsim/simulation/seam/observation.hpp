#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "robsim/imaging/plane_map.hpp"
#include "robsim/model/robot_model.hpp"
#include "robsim/vision/locate.hpp"

namespace robsim {

/// One sample for the parameter estimator: that of step k.
struct Sample {
  Regression regression;
  std::int64_t k = 0;
};

/// What the world half hands over at a step. Its frame is made when somebody looks: see Camera.
struct Observation {
  double t = 0;                     // s
  std::optional<double> t_arrival;  // s, by the same clock: when its frame reached this computer
  bool has_frame = true;

  // What was found out elsewhere: the input that the robot really got since the last step, where it
  // was seen, and the sample for the parameter estimator.
  std::optional<Input> last_u;
  std::optional<Measurement> measurement;
  std::optional<Sample> sample;
  bool interrupted = false;  // the robot was stopped since the last step

  /// Empties it for the next step: making a new one takes longer.
  void clear() {
    t_arrival.reset();
    has_frame = true;
    last_u.reset();
    measurement.reset();
    sample.reset();
    interrupted = false;
  }
};

/// The camera as the robot half knows it.
class Camera {
 public:
  virtual ~Camera() = default;

  /// The frame of the newest step.
  virtual Frame frame() = 0;
};

/// What fills a slot: a native component or a callable of the interpreter's. Empty = off.
template <typename Signature>
struct Slot {
  std::function<Signature> call;
  bool is_interpreted = false;

  explicit operator bool() const { return static_cast<bool>(call); }
};

}  // namespace robsim
