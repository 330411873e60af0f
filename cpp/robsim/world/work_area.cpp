#include "robsim/world/work_area.hpp"

#include <algorithm>
#include <cmath>

namespace robsim {

namespace {

// Mirrors one coordinate at the wall that it runs into, if it does.
bool mirror(double low, double high, double& now, double& last) {
  double wall = 0;
  if (now < low && now < last) {
    wall = low;
  } else if (now > high && now > last) {
    wall = high;
  } else {
    return false;
  }
  now = 2 * wall - now;
  last = 2 * wall - last;
  return true;
}

// The same until it is inside: how often. A robot faster than the room meets both walls in a step.
int mirror_all(double low, double high, double& now, double& last) {
  constexpr int most = 1000;
  int count = 0;
  while (count < most && mirror(low, high, now, last)) ++count;
  return count;
}

constexpr double farthest = 1e9;  // pixels: the view ends there, within the range of int

int moved(int shift, double pixel, int size, double margin) {
  pixel = std::clamp(pixel, -farthest, farthest);
  const double room = std::min(margin, size / 2.0 - 1);
  if (pixel - shift < room) return static_cast<int>(std::floor(pixel - room));
  if (pixel - shift > size - 1 - room)
    return static_cast<int>(std::ceil(pixel - (size - 1 - room)));
  return shift;
}

}  // namespace

bool bounce(const WorkArea& area, double radius, Pose& now, Pose& last) {
  // The area reaches half a pixel beyond the centres of its outermost pixels.
  const int x = mirror_all(radius - 0.5, area.width - 0.5 - radius, now.x, last.x);
  const int y = mirror_all(radius - 0.5, area.height - 0.5 - radius, now.y, last.y);
  for (Pose* pose : {&now, &last}) {
    if (x % 2 == 1) pose->heading = wrap_angle(pi - pose->heading);
    if (y % 2 == 1) pose->heading = wrap_angle(-pose->heading);
  }
  return x > 0 || y > 0;
}

Pan follow(const Pan& pan, const Point& pixel, int width, int height, double margin) {
  return {moved(pan.u, pixel.x, width, margin), moved(pan.v, pixel.y, height, margin)};
}

}  // namespace robsim
