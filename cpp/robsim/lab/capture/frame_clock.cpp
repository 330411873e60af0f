#include "robsim/lab/capture/frame_clock.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace robsim {

namespace {

constexpr double most_drift = 1e-4;  // of a device's clock against ours, s/s
constexpr double shortest = 1e-6;    // s between two frames

constexpr double early = 0.25;         // intervals by which a frame may seem to come early
constexpr double creep = 0.02;         // towards a frame that came late
constexpr double first_measured = 16;  // intervals, over which their length is measured
constexpr double most_measured = 160;
constexpr double kept = 0.5;       // of a fraction of an interval, for the next frame
constexpr double credible = 0.25;  // relative deviation of the interval from what is seen

}  // namespace

FrameClock::FrameClock(std::optional<double> interval)
    : interval_(interval.value_or(0)),
      is_known_(interval),
      measured_(interval ? most_measured : first_measured) {}

double FrameClock::time_of(const Captured& captured) {
  double time;
  if (captured.exposed) {
    time = *captured.exposed;
  } else if (captured.device_time && (!device_last_ || *captured.device_time > *device_last_)) {
    time = by_device(*captured.device_time, captured.arrived);
  } else {
    device_last_.reset();
    time = by_arrival(captured.arrived);
  }
  if (last_) time = std::max(time, *last_ + shortest);
  last_ = time;
  last_arrival_ = captured.arrived;
  return time;
}

void FrameClock::restart() {
  last_arrival_.reset();
  device_last_.reset();
  n_differences_ = 0;
}

double FrameClock::by_device(double device_time, double arrived) {
  const double delay = arrived - device_time;
  // offset = min over the frames so far of (arrival - device time), which may drift
  offset_ =
      device_last_ ? std::min(delay, offset_ + most_drift * (device_time - *device_last_)) : delay;
  device_last_ = device_time;
  return device_time + offset_;
}

double FrameClock::by_arrival(double arrived) {
  if (!last_ || !last_arrival_) {
    mark(arrived);
    return arrived;
  }
  if (has_new_interval(arrived)) {
    measured_ = first_measured;
    mark(arrived);
    return arrived;
  }
  // t' = t + n T;  t = min(t' + c (arrival - t'), arrival)
  const double intervals = std::max(1.0, std::floor((arrived - *last_) / interval_ + early));
  const double predicted = *last_ + intervals * interval_;
  const double time = std::min(predicted + creep * (arrived - predicted), arrived);
  n_since_mark_ += intervals_to(arrived);
  if (n_since_mark_ >= measured_) {
    interval_ = (arrived - mark_) / n_since_mark_;
    measured_ = std::min(2 * measured_, most_measured);
    mark(arrived);
  }
  return time;
}

// From arrival to arrival: predicted times drift with a wrong interval, and would confirm it. What
// is left of a late frame is taken off those behind it, in part: a wrong interval must not add up.
double FrameClock::intervals_to(double arrived) {
  const double passed = (arrived - *last_arrival_) / interval_ + left_over_;
  const double whole = std::max(0.0, std::round(passed));
  left_over_ = kept * (passed - whole);
  return whole;
}

void FrameClock::mark(double arrived) {
  mark_ = arrived;
  n_since_mark_ = 0;
}

// True if the frames are further apart, or nearer, than was thought, or nothing was known.
bool FrameClock::has_new_interval(double arrived) {
  differences_[n_differences_++ % watched] = arrived - *last_arrival_;
  const std::size_t count = std::min(n_differences_, watched);
  if (is_known_ && count < watched) return false;
  auto sorted = differences_;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(sorted.begin(), middle, sorted.begin() + static_cast<std::ptrdiff_t>(count));
  const double before = interval_;
  if (*middle > 0 && (!is_known_ || std::abs(*middle - interval_) > credible * interval_)) {
    interval_ = *middle;
  }
  const bool was_known = std::exchange(is_known_, is_known_ || count == watched);
  return was_known ? interval_ != before : before <= 0;
}

}  // namespace robsim
