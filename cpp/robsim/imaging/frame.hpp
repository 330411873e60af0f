#pragma once

#include <cstdint>

#include "robsim/imaging/image.hpp"
#include "robsim/imaging/plane_map.hpp"

namespace robsim {

/// What the camera delivers: everything the robot half knows about the world.
struct Frame {
  Image image;
  double t = 0;  // s
  std::int64_t index = 0;
  PlaneMap plane_map;
};

}  // namespace robsim
