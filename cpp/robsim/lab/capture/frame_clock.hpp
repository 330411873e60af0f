#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "robsim/lab/capture/capture_device.hpp"

namespace robsim {

/// When frames were exposed, as far as can be told (monotonic, s). A frame arrives late by chance,
/// never early: of the device's own clock the least delay seen is taken for its offset; without
/// one, frames are one interval apart, and the earliest arrivals say where they stand.
class FrameClock {
 public:
  /// `interval` is the time between two frames (s), if it is known.
  explicit FrameClock(std::optional<double> interval = {});

  /// The time of the next frame: later than that of the one before, never after its arrival.
  double time_of(const Captured& captured);

  /// The camera starts anew, such as after it was unplugged.
  void restart();

 private:
  double by_device(double device_time, double arrived);
  double by_arrival(double arrived);
  bool has_new_interval(double arrived);
  double intervals_to(double arrived);
  void mark(double arrived);

  static constexpr std::size_t watched = 15;

  double interval_;  // s; 0: not known yet
  bool is_known_;    // but for its last digits
  std::optional<double> last_, last_arrival_;
  std::optional<double> device_last_;
  double offset_ = 0;        // of our clock over the device's, s
  double measured_;          // intervals over which the next one is measured
  double mark_ = 0;          // arrival from which the interval is measured, s
  double n_since_mark_ = 0;  // intervals
  double left_over_ = 0;     // intervals
  std::array<double, watched> differences_{};
  std::size_t n_differences_ = 0;
};

}  // namespace robsim
