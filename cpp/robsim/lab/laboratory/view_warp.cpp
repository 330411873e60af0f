#include "robsim/lab/laboratory/view_warp.hpp"

#include <limits>

namespace robsim {

namespace {

// The third component of what a homography makes of a pixel: its sign changes at the horizon.
double depth(const PlaneMap& map, const Point& pixel) {
  const PlaneMap::Matrix& m = map.matrix();
  const Point ideal = map.ideal(pixel);
  return m[6] * ideal.x + m[7] * ideal.y + m[8];
}

}  // namespace

Warp view_warp(const Scene& scene, int width, int height, const PlaneMap& plane_map) {
  constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();
  const bool is_seen_in_front = depth(plane_map, {(width - 1) / 2.0, (height - 1) / 2.0}) > 0;
  return Warp(width, height, scene.width(), scene.height(), [&](const Point& pixel) -> Point {
    if ((depth(plane_map, pixel) > 0) != is_seen_in_front) return {nowhere, nowhere};
    return scene.camera().to_pixel(plane_map.to_world(pixel));
  });
}

}  // namespace robsim
