#include "robsim/simulation/world/external_world.hpp"

#include <stdexcept>
#include <string>
#include <utility>

#include "robsim/text/to_text.hpp"

namespace robsim {

namespace {

std::string seconds(double t) { return "t = " + to_text(t) + " s"; }

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height) + " px";
}

std::optional<double> own_time(const Arrived& arrived) {
  if (arrived.t) return arrived.t;
  return arrived.frame ? arrived.frame->t : std::nullopt;
}

}  // namespace

void ExternalWorld::start(const RobotModel& model) {
  dt_ = model.dt();
  last_t_ = 0;
  has_times_ = false;
  width_ = height_ = 0;
}

void ExternalWorld::reset() { frame_.reset(); }

Arrival ExternalWorld::next(std::int64_t k, Observation& observation) {
  Arrived arrived;
  const Arrival arrival = source_.take(k, arrived);
  if (arrival != Arrival::step) return arrival;
  if (arrived.frame) check_size(k, arrived.frame->image);
  arrived.known.t = time_of(k, arrived);
  arrived.known.has_frame = arrived.frame.has_value();
  is_guessed_ = !own_time(arrived);
  has_times_ = has_times_ || !is_guessed_;
  last_t_ = arrived.known.t;
  frame_ = std::move(arrived.frame);
  observation = std::move(arrived.known);
  return Arrival::step;
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

void ExternalWorld::send(std::int64_t k, const Input& u) {
  if (source_.send) source_.send(k, u);
}

std::optional<Input> ExternalWorld::stop() noexcept {
  return source_.stop ? source_.stop() : std::nullopt;
}

Frame ExternalWorld::frame() {
  if (frame_) return *frame_;
  throw std::runtime_error("there is no frame yet: run a step");
}

}  // namespace robsim
