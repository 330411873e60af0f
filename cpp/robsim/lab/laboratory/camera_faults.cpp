#include "robsim/lab/laboratory/camera_faults.hpp"

#include <algorithm>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/geometry.hpp"

namespace robsim {

namespace {
constexpr std::uint64_t draws_of_a_tick = 8;
}  // namespace

double CameraFaults::uniform(std::int64_t tick, Draw draw) const {
  return random_uniform(
      seed, draws_of_a_tick * static_cast<std::uint64_t>(tick) + static_cast<std::uint64_t>(draw));
}

double CameraFaults::lateness_of(std::int64_t tick) const {
  return uniform(tick, Draw::late) < late ? lateness : 0;
}

bool CameraFaults::drops(std::int64_t tick) const { return uniform(tick, Draw::dropped) < dropped; }

bool CameraFaults::repeats(std::int64_t tick) const {
  return uniform(tick, Draw::repeated) < repeated;
}

bool CameraFaults::tears(std::int64_t tick) const { return uniform(tick, Draw::torn) < torn; }

int CameraFaults::torn_row(std::int64_t tick, int height) const {
  return std::min(height - 1, 1 + static_cast<int>(uniform(tick, Draw::row) * (height - 1)));
}

bool CameraFaults::tears_into_the_last(std::int64_t tick) const {
  return uniform(tick, Draw::rest) < 0.5;
}

double CameraFaults::exposure_at(double t) const {
  return drift == 0 ? 1 : 1 + drift * elementary::sin(2 * pi * t / drift_period);
}

}  // namespace robsim
