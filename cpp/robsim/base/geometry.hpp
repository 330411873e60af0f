#pragma once

#include <cmath>
#include <string>
#include <vector>

namespace robsim {

constexpr double pi = 3.14159265358979323846;

/// A position in the plane. The unit is the caller's: pixels of a frame, or of the work area.
struct Point {
  double x = 0;
  double y = 0;
};

/// Position (work-area px, x right, y down) and heading (rad, from +x towards +y, in (-pi, pi]).
struct Pose {
  double x = 0;
  double y = 0;
  double heading = 0;
};

/// `wrap_angle` outside (-pi, pi].
double wrap_far_angle(double angle);

/// The angle in (-pi, pi] that differs from `angle` (rad) by full turns. Angles wrap here only.
inline double wrap_angle(double angle) {
  return angle > -pi && angle <= pi ? angle : wrap_far_angle(angle);
}

inline bool is_finite(const Pose& pose) {
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.heading);
}

using Polygon = std::vector<Point>;

/// Throws std::invalid_argument, naming `name`, unless the polygon has 3 to 1000 corners within
/// 1e9 px, an area, and its centroid among its corners.
void check_polygon(const Polygon& polygon, const std::string& name);

/// Area by the shoelace formula, always positive.
double polygon_area(const Polygon& polygon);

/// Centroid of the area inside the polygon.
Point polygon_centroid(const Polygon& polygon);

}  // namespace robsim
