#pragma once

#include <cstdint>
#include <optional>

#include "robsim/imaging/image.hpp"
#include "robsim/imaging/plane_map.hpp"

namespace robsim {

/// What the camera delivers: everything the robot half knows about the world.
struct Frame {
  Image image;
  std::optional<double> t;          // s; none of its own: it is one sample time after the last one
  std::optional<double> t_arrival;  // s, by the same clock: when it reached this computer
  std::optional<double> epoch;      // s, monotonic: t = 0 of this clock
  std::int64_t index = 0;
  PlaneMap plane_map;
  int headings = 0;  // that the robot is drawn in, at whole pixels; 0 = any, as a camera sees it
};

}  // namespace robsim
