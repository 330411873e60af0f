#pragma once

#include <algorithm>
#include <cstdint>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/geometry.hpp"

namespace robsim {

/// A time that something lasts, counted from the start of the world (s).
struct TimeSpan {
  double start = 0;
  double duration = 0;

  bool has(double t) const { return t >= start && t < start + duration; }
};

/// What goes wrong with a simulated camera. What happens to the frame of a tick depends on seed and
/// tick alone.
struct CameraFaults {
  // Probabilities of a frame.
  double late = 0;
  double dropped = 0;
  double repeated = 0;
  double torn = 0;

  double lateness = 0;      // of a late one, s
  TimeSpan stall;           // no frames
  TimeSpan unplugged;       // no camera
  double drift = 0;         // of the exposure, relative to what it should be
  double drift_period = 1;  // s
  std::uint64_t seed = 0;

  /// By how much later than others the frame of a tick comes (s).
  double lateness_of(std::int64_t tick) const {
    return uniform(tick, Draw::late) < late ? lateness : 0;
  }

  bool drops(std::int64_t tick) const { return uniform(tick, Draw::dropped) < dropped; }
  bool repeats(std::int64_t tick) const { return uniform(tick, Draw::repeated) < repeated; }
  bool tears(std::int64_t tick) const { return uniform(tick, Draw::torn) < torn; }

  /// The row from which on a torn frame is not what it should be, 1..height - 1.
  int torn_row(std::int64_t tick, int height) const {
    const double place = uniform(tick, Draw::row) * (height - 1);
    return std::min(height - 1, 1 + static_cast<int>(place));
  }

  /// True if a torn frame has the one before in its lower part: else nothing is there.
  bool tears_into_the_last(std::int64_t tick) const { return uniform(tick, Draw::rest) < 0.5; }

  /// Brightness as a multiple of what it should be.
  double exposure_at(double t) const {
    return drift == 0 ? 1 : 1 + drift * elementary::sin(2 * pi * t / drift_period);
  }

 private:
  enum class Draw : std::uint64_t { late, dropped, repeated, torn, row, rest };

  double uniform(std::int64_t tick, Draw draw) const {
    constexpr std::uint64_t draws_of_a_tick = 8;
    return random_uniform(seed, draws_of_a_tick * static_cast<std::uint64_t>(tick) +
                                    static_cast<std::uint64_t>(draw));
  }
};

}  // namespace robsim
