#pragma once

#include <functional>
#include <optional>

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
  std::function<void(std::int64_t k, const Input& u)> send;  // empty: nobody wants the inputs
  std::function<std::optional<Input>()> stop;                // see World::stop; must not throw
};

/// The world half outside: frames from a recording, a camera or another process.
class ExternalWorld : public World {
 public:
  explicit ExternalWorld(ExternalSource source) : source_(std::move(source)) {}

  void start(const RobotModel& model) override;
  void reset() override;

  /// Throws std::invalid_argument for frames whose times do not grow, or whose size changes.
  Arrival next(std::int64_t k, Observation& observation) override;
  void send(std::int64_t k, const Input& u) override;
  std::optional<Input> stop() noexcept override;
  bool is_interpreted() const override { return true; }
  Frame frame() override;

 private:
  double time_of(std::int64_t k, const Arrived& arrived) const;
  void check_size(std::int64_t k, const Image& image);

  ExternalSource source_;
  double dt_ = 0;               // s, of the model
  bool is_guessed_ = false;     // the time of the last step was
  double last_t_ = 0;           // s
  bool has_times_ = false;      // the frames bring their times
  int width_ = 0, height_ = 0;  // of the frames, px; 0 = none yet
  std::optional<Frame> frame_;
};

}  // namespace robsim
