#include "robsim/simulation/world/external_world.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "robsim/base/system.hpp"
#include "robsim/simulation/seam/thread_guard.hpp"

namespace robsim {

namespace {

constexpr double first_frame = 10;   // frame_timeouts
constexpr double jitter_factor = 2;  // by which the time-out exceeds the gaps between frames
constexpr double most_proposed = 1;  // s; what takes longer is no jitter

std::string seconds(double t) { return "t = " + to_text(t) + " s"; }

std::optional<double> own_time(const Arrived& arrived) {
  if (arrived.t) return arrived.t;
  return arrived.frame ? arrived.frame->t : std::nullopt;
}

}  // namespace

ExternalWorld::ExternalWorld(FrameSource frames, InputSink inputs, double frame_timeout,
                             const std::optional<Limits>& limits, double longest_timeout)
    : frames_(std::move(frames)),
      inputs_(std::move(inputs)),
      frame_timeout_(frame_timeout),
      longest_timeout_(longest_timeout),
      limits_(limits) {
  const bool is_watched = inputs_.halt && !std::isinf(frame_timeout);
  if (is_watched) watchdog_ = std::make_unique<Watchdog>(inputs_.halt);
}

void ExternalWorld::close() noexcept {
  const bool drives = t_of_sent_.has_value() && !inputs_.is_interpreted;
  if (drives) inputs_.stop();
  const NativeWork native;  // it may be waiting for the interpreter
  watchdog_.reset();
}

void ExternalWorld::start(const RobotModel& model) {
  dt_ = model.dt();
  last_t_ = 0;
  has_times_ = false;
  epoch_.reset();
  width_ = height_ = 0;
}

void ExternalWorld::reset() { frame_.reset(); }

Arrival ExternalWorld::next(std::int64_t k, Observation& observation) {
  if (!waiting_since_) waiting_since_ = monotonic_now();
  Arrived arrived;
  const Arrival arrival = frames_.take(k, arrived);
  if (arrival == Arrival::nothing_yet) check_wait(k);
  if (arrival != Arrival::step) return arrival;
  waiting_since_.reset();
  const bool is_fresh = arrived.frame || arrived.known.measurement;
  if (arrived.frame) check_size(k, arrived.frame->image);
  arrived.known.t = time_of(k, arrived);
  arrived.known.has_frame = arrived.frame.has_value();
  is_guessed_ = !own_time(arrived);
  has_times_ = has_times_ || !is_guessed_;
  last_t_ = arrived.known.t;
  note_arrival(arrived, is_fresh);
  frame_ = std::move(arrived.frame);
  observation = std::move(arrived.known);
  return Arrival::step;
}

void ExternalWorld::note_arrival(Arrived& arrived, bool is_fresh) {
  const double now = monotonic_now();
  if (arrived.frame) epoch_ = arrived.frame->epoch;
  if (arrived.frame && epoch_) {
    arrived.known.t_arrival = arrived.frame->t_arrival.value_or(now - *epoch_);
  }
  if (!is_fresh) return;
  const double before = last_arrival_;
  last_arrival_ = arrived.known.t_arrival ? *arrived.known.t_arrival + *epoch_ : now;
  if (!is_armed_) return;
  // In whole ms, for the message
  const double needed = std::ceil(1000 * jitter_factor * (last_arrival_ - before)) / 1000;
  frame_timeout_ = std::max(frame_timeout_, std::min(needed, longest_timeout_));
  watchdog_->set_timeout(frame_timeout_);
  watchdog_->feed(last_arrival_);
}

double ExternalWorld::time_of(std::int64_t k, const Arrived& arrived) const {
  const std::optional<double> own = own_time(arrived);
  if (!own && has_times_ && arrived.frame) {
    throw std::invalid_argument("frames must all have a time t, or none of them: that of step " +
                                std::to_string(k) + " has none, those before have");
  }
  if (!own) return has_times_ ? last_t_ + dt_ : static_cast<double>(k) * dt_;
  if (k > 0 && !(*own > last_t_)) {
    throw std::invalid_argument(
        "frames must come in the order of their times: that of step " + std::to_string(k) +
        " is of " + seconds(*own) + ", the one before of " + seconds(last_t_) +
        (is_guessed_ ? ", for want of its own: give it with Observation(t=...)" : ""));
  }
  return *own;
}

void ExternalWorld::check_size(std::int64_t k, const Image& image) {
  if (width_ == 0) {
    width_ = image.width();
    height_ = image.height();
  }
  if (image.width() == width_ && image.height() == height_) return;
  throw std::invalid_argument("frames must all have one size: that of step " + std::to_string(k) +
                              " is " + size_text(image.width(), image.height()) +
                              ", those before " + size_text(width_, height_));
}

Sent ExternalWorld::send(std::int64_t k, const Input& u) {
  if (!inputs_.send) return {u, std::nullopt};
  check_watchdog(k);
  if (watchdog_ && !is_armed_) {
    watchdog_->arm(frame_timeout_);
    watchdog_->feed(last_arrival_);
    is_armed_ = true;
  }
  const double since = t_of_sent_ ? last_t_ - *t_of_sent_ : dt_;
  const Input limited = limits_ ? limits_->applied(u, last_sent_, since) : u;
  const std::optional<double> sent = inputs_.send(k, limited);
  check_watchdog(k);  // nobody knows which came last: the end of the run stops it again
  last_sent_ = limited;
  t_of_sent_ = last_t_;
  if (!epoch_) return {limited, std::nullopt};
  return {limited, sent.value_or(monotonic_now()) - *epoch_};
}

void ExternalWorld::check_wait(std::int64_t k) const {
  const double limit = k == 0 ? first_frame * frame_timeout_ : frame_timeout_;
  if (monotonic_now() - *waiting_since_ < limit) return;
  throw FrameTimeout("no frame came for step " + std::to_string(k) + " within " +
                     (k == 0 ? to_text(first_frame) + " times " : "") + "frame_timeout = " +
                     to_text(frame_timeout_) + " s" + (k == 0 ? "" : proposal()));
}

// A time-out for frames as late as this one.
std::string ExternalWorld::proposal() const {
  const double enough = jitter_factor * (monotonic_now() - last_arrival_);
  if (enough > most_proposed) return "";
  return "; for a frame that is only late, " + to_text(std::ceil(20 * enough) / 20) +
         " s is enough";
}

void ExternalWorld::check_watchdog(std::int64_t k) const {
  if (!is_armed_ || !watchdog_->has_expired()) return;
  throw FrameTimeout("the robot was stopped, as no fresh frame was taken within frame_timeout = " +
                     to_text(frame_timeout_) + " s of the arrival of that of step " +
                     std::to_string(k) +
                     ": make the callbacks faster, or give a longer frame_timeout" + proposal());
}

std::optional<Input> ExternalWorld::stop() noexcept {
  waiting_since_.reset();
  if (is_armed_) {
    const NativeWork native;  // it may be waiting for the interpreter
    watchdog_->disarm();
    is_armed_ = false;
  }
  const std::optional<Input> stopped = inputs_.stop ? inputs_.stop() : std::nullopt;
  if (stopped) {
    last_sent_ = *stopped;
    t_of_sent_.reset();
  }
  return stopped;
}

Frame ExternalWorld::frame() {
  if (frame_) return *frame_;
  throw std::runtime_error("there is no frame yet: run a step");
}

}  // namespace robsim
