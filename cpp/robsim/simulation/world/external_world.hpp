#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>

#include "robsim/lab/motors/safety.hpp"
#include "robsim/simulation/seam/world.hpp"

namespace robsim {

/// What an external source brings at a step.
struct Arrived {
  std::optional<Frame> frame;
  std::optional<double> t;  // s; of a step without a frame, or in place of the frame's own
  Observation known;        // what was found out elsewhere
};

/// Where frames come from.
struct FrameSource {
  std::function<Arrival(std::int64_t k, Arrived& arrived)> take;
  bool is_live = false;  // they come at their own pace
  bool is_interpreted = true;
};

/// Where inputs go to.
struct InputSink {
  // Returns when it went out (monotonic, s), if it knows; empty: nobody wants the inputs.
  std::function<std::optional<double>(std::int64_t k, const Input& u)> send;
  std::function<std::optional<Input>()> stop;  // see World::stop; must not throw
  std::function<void()> halt;  // for the watchdog, must not throw; empty: no watchdog
  bool is_interpreted = true;
  std::function<bool()> is_silent = {};  // see World::is_robot_silent
};

/// No fresh frame came in time: the robot was stopped.
class FrameTimeout : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The world half outside: frames from a recording, a camera or another process. Where a robot
/// drives, a watchdog stops it when no fresh frame comes, whatever keeps the loop from asking.
class ExternalWorld : public World {
 public:
  /// Waits for a frame at most for `frame_timeout` (s, inf = any time), and ten times as long for
  /// the first frame: a camera may have to warm up, and the robot still stands. A watchdog halts
  /// the robot when that time has passed since the arrival of the last fresh frame. Inputs are held
  /// to `limits` before they are sent. While the robot drives, the time-out grows to twice the
  /// longest time between the arrivals of two frames taken, up to `longest_timeout` (s).
  ExternalWorld(FrameSource frames, InputSink inputs, double frame_timeout,
                const std::optional<Limits>& limits = {}, double longest_timeout = 0);

  void start(const RobotModel& model) override;
  void reset() override;

  /// Stops a robot behind a link, and ends the watchdog, which calls others from its thread.
  void close() noexcept;

  /// Throws FrameTimeout, and std::invalid_argument for frames whose times do not grow, or whose
  /// size changes.
  Arrival next(std::int64_t k, Observation& observation) override;
  /// Throws FrameTimeout if the watchdog has stopped the robot.
  Sent send(std::int64_t k, const Input& u) override;
  std::optional<Input> stop() noexcept override;
  bool is_interpreted() const override {
    return frames_.is_interpreted || (inputs_.send && inputs_.is_interpreted);
  }
  bool is_live() const override { return frames_.is_live || epoch_; }
  bool is_robot_silent() const override { return inputs_.is_silent && inputs_.is_silent(); }
  bool was_stopped() const override { return is_armed_ && watchdog_->has_expired(); }
  Frame frame() override;

 private:
  void note_arrival(Arrived& arrived, bool is_fresh);
  void check_wait(std::int64_t k) const;
  void check_watchdog(std::int64_t k) const;
  std::string proposal() const;
  double time_of(std::int64_t k, const Arrived& arrived) const;
  void check_size(std::int64_t k, const Image& image);

  FrameSource frames_;
  InputSink inputs_;
  double frame_timeout_;                 // s
  const double longest_timeout_;         // s
  std::optional<double> waiting_since_;  // monotonic, s, for the next frame
  std::unique_ptr<Watchdog> watchdog_;   // null: it is off
  bool is_armed_ = false;
  const std::optional<Limits> limits_;
  Input last_sent_;
  std::optional<double> t_of_sent_;  // s, of the step that sent it; nothing after a stop
  double last_arrival_ = 0;          // monotonic, s
  double dt_ = 0;                    // s, of the model
  bool is_guessed_ = false;          // the time of the last step was
  double last_t_ = 0;                // s
  bool has_times_ = false;           // the frames bring their times
  std::optional<double> epoch_;      // s, monotonic: t = 0 of the newest frame that says so
  int width_ = 0, height_ = 0;       // of the frames, px; 0 = none yet
  std::optional<Frame> frame_;
};

}  // namespace robsim
