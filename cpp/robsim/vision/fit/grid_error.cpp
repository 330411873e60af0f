#include "robsim/vision/fit/grid_error.hpp"

#include <algorithm>
#include <cmath>

#include "robsim/base/elementary/elementary.hpp"

namespace robsim::fit {

namespace {

// Measured on squares without blur, in frames of 480 and 1200 px.
constexpr double largest = 0.1;                      // frame px
constexpr double sharp_blur = 0.46, no_blur = 0.56;  // frame px: where it is that, and 0

}  // namespace

double grid_error(double blur) {
  return largest * std::clamp((no_blur - blur) / (no_blur - sharp_blur), 0.0, 1.0);
}

double grid_share(const MarkerShape& shape, const Pose& pose, const PlaneMap& map) {
  const auto [sin, cos] = elementary::sin_cos(pose.heading);
  const Polygon& polygon = shape.polygon();
  const auto corner = [&, sin = sin, cos = cos](std::size_t i) {
    const Point& at = polygon[i % polygon.size()];
    return map.to_pixel({pose.x + at.x * cos - at.y * sin, pose.y + at.x * sin + at.y * cos});
  };
  double squares = 0, all = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point from = corner(i), to = corner(i + 1);
    const double across = std::fabs(to.x - from.x), down = std::fabs(to.y - from.y);
    const double length = elementary::hypot(across, down);
    const double alike = length / std::max(1.0, pi * std::min(across, down));
    squares += alike * alike;
    all += length;
  }
  // place = 2 sum n error length / all, half of whose variance is in x, half in y
  return 2 * squares / (all * all);
}

}  // namespace robsim::fit
