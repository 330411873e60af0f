#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "robsim/lab/motors/motor_receiver.hpp"
#include "robsim/simulation/world/simulated_world.hpp"

namespace robsim {

/// The simulated world in real time, in a thread of its own: at each tick the robot moves by one
/// step, with the mean of the input that it has acted on since the last one. It goes on whether a
/// camera looks or not. Its methods are for any thread.
class Laboratory {
 public:
  /// What there is to know of a tick.
  struct Tick {
    double time = 0;  // monotonic, s
    Pose pose;
    Input last_u;             // the mean since the tick before
    bool hidden = false;      // from the camera
    std::int64_t shown = -1;  // the tick of the picture that the camera delivered; -1: of none
  };

  /// Ticks from a number on.
  struct Record {
    std::int64_t first = 0;
    std::vector<Tick> ticks;
  };

  static constexpr std::size_t longest_record = 1'000'000;  // ticks

  /// Starts the world with a model, whose dt is the time from tick to tick. `input` is what its
  /// robot receives. The world needs no interpreter, and belongs to it from now on.
  Laboratory(std::shared_ptr<SimulatedWorld> world, const RobotModel& model,
             std::shared_ptr<const ReceivedInput> input);
  ~Laboratory();
  Laboratory(const Laboratory&) = delete;
  Laboratory& operator=(const Laboratory&) = delete;

  /// Tick 0 comes now, if it has not come yet. Throws std::runtime_error after `close`.
  void start();

  /// Ends the world for good.
  void close() noexcept;

  /// True in a process that was forked from the one where it runs: nothing moves there, and nothing
  /// of it may be used.
  bool is_elsewhere() const;

  double dt() const { return dt_; }
  double time_of(std::int64_t tick) const;  // monotonic, s; after the start
  std::int64_t first_tick_from(double time) const;

  Record record() const;
  Tick tick(std::int64_t k) const;  // that has come, and is not too old

  // What the camera reports: of which tick the picture is that it delivers at a tick, and that it
  // was too late to draw one.
  void set_shown(std::int64_t k, std::int64_t shown);

  void count_skipped() { ++skipped_; }
  std::int64_t skipped() const { return skipped_; }

  // What may be done to the camera meanwhile.
  void stall(double seconds);
  void unplug();
  void plug_in();
  bool is_unplugged() const { return is_unplugged_; }
  bool is_stalled_at(double time) const { return time < stalled_until_; }

  /// Takes the camera, which one alone can have; false if somebody has it.
  bool take_camera() { return !is_camera_taken_.exchange(true); }
  void give_camera_back() { is_camera_taken_ = false; }

  /// Waits until a tick has come and the time is `due`: true. False at `deadline`, and before it if
  /// the camera is unplugged, or it is interrupted. Throws std::runtime_error if the world has
  /// ended.
  bool wait_for(std::int64_t k, double due, double deadline,
                const std::atomic<bool>& is_interrupted) const;

  /// Lets who waits look anew.
  void wake() const;

 private:
  void run();
  void move(std::int64_t k, const Input& u);
  std::int64_t end() const { return first_ + static_cast<std::int64_t>(ticks_.size()); }

  const std::shared_ptr<SimulatedWorld> world_;
  const std::shared_ptr<const ReceivedInput> input_;
  const double dt_;
  const long long process_;

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::thread thread_;
  double start_ = 0;  // monotonic, s; set before the thread starts
  std::deque<Tick> ticks_;
  std::int64_t first_ = 0;  // the number of the first one kept
  bool has_started_ = false;
  bool is_closed_ = false;
  std::string failure_;

  std::atomic<std::int64_t> skipped_{0};
  std::atomic<double> stalled_until_{0};
  std::atomic<bool> is_unplugged_{false};
  std::atomic<bool> is_camera_taken_{false};
};

}  // namespace robsim
