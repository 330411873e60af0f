#include "robsim/world/work_area.hpp"

#include <algorithm>
#include <cmath>

namespace robsim {

namespace {

// Mirrors a coordinate and its predecessor at the wall that it runs into, if any.
bool mirror(double low, double high, double& current, double& previous) {
  double wall = 0;
  if (current < low && current < previous) {
    wall = low;
  } else if (current > high && current > previous) {
    wall = high;
  } else {
    return false;
  }
  current = 2 * wall - current;
  previous = 2 * wall - previous;
  return true;
}

// Mirrors until the coordinate is inside and returns how often: in one step a fast robot may cross
// the whole area. Beyond all speeds of robots it stops at the wall.
int mirror_all(double low, double high, double& current, double& previous) {
  constexpr int maximum = 1000;
  int count = 0;
  while (count < maximum && mirror(low, high, current, previous)) ++count;
  if (count == maximum && low < high) {
    const double inside = std::clamp(current, low, high);
    previous -= current - inside;
    current = inside;
  }
  return count;
}

constexpr double maximum_pan = 1e9;  // px; within the range of int

// The pan along one axis.
int panned(int pan, double pixel, int size, double margin) {
  pixel = std::clamp(pixel, -maximum_pan, maximum_pan);
  const double clearance = std::min(margin, size / 2.0 - 1);
  if (pixel - pan < clearance) return static_cast<int>(std::floor(pixel - clearance));
  if (pixel - pan > size - 1 - clearance) {
    return static_cast<int>(std::ceil(pixel - (size - 1 - clearance)));
  }
  return pan;
}

}  // namespace

bool bounce(const WorkArea& area, double radius, Pose& current, Pose& previous) {
  // The area extends half a pixel beyond the centres of its outermost pixels.
  const int x = mirror_all(radius - 0.5, area.width - 0.5 - radius, current.x, previous.x);
  const int y = mirror_all(radius - 0.5, area.height - 0.5 - radius, current.y, previous.y);
  for (Pose* pose : {&current, &previous}) {
    if (x % 2 == 1) pose->heading = wrap_angle(pi - pose->heading);
    if (y % 2 == 1) pose->heading = wrap_angle(-pose->heading);
  }
  return x > 0 || y > 0;
}

Pan follow(const Pan& pan, const Point& pixel, int width, int height, double margin) {
  return {panned(pan.u, pixel.x, width, margin), panned(pan.v, pixel.y, height, margin)};
}

}  // namespace robsim
