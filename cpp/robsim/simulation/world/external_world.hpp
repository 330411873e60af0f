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

/// Where frames come from and inputs go to.
struct ExternalSource {
  std::function<Arrival(std::int64_t k, Arrived& arrived)> take;
  // Returns when it went out (monotonic, s), if it knows; empty: nobody wants the inputs.
  std::function<std::optional<double>(std::int64_t k, const Input& u)> send;
  std::function<std::optional<Input>()> stop;  // see World::stop; must not throw
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
  explicit ExternalWorld(ExternalSource source) : source_(std::move(source)) {}

  /// Has a watchdog stop the robot by `stop_robot`, in another thread, when no fresh frame is taken
  /// within so long (s) of the arrival of the one before; it must not throw.
  void watch(double frame_timeout, std::function<void()> stop_robot);

  /// What the inputs are held to, before they are sent.
  void set_limits(const Limits& limits) { limits_ = limits; }

  void start(const RobotModel& model) override;
  void reset() override;

  /// Has no watchdog any more, and so calls nobody from another thread.
  void close() noexcept;

  /// Throws std::invalid_argument for frames whose times do not grow, or whose size changes.
  Arrival next(std::int64_t k, Observation& observation) override;
  /// Throws FrameTimeout if the watchdog has stopped the robot.
  Sent send(std::int64_t k, const Input& u) override;
  std::optional<Input> stop() noexcept override;
  bool is_interpreted() const override { return true; }
  bool is_live() const override { return epoch_.has_value(); }
  bool was_stopped() const override { return is_armed_ && watchdog_->has_expired(); }
  Frame frame() override;

 private:
  void note_arrival(Arrived& arrived, bool is_fresh);
  void check_watchdog(std::int64_t k) const;
  double time_of(std::int64_t k, const Arrived& arrived) const;
  void check_size(std::int64_t k, const Image& image);

  ExternalSource source_;
  std::unique_ptr<Watchdog> watchdog_;  // null: nobody watches
  double frame_timeout_ = 0;            // s
  bool is_armed_ = false;
  std::optional<Limits> limits_;
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
