#pragma once

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

/// The angle in (-pi, pi] that differs from `angle` (rad) by full turns. Angles wrap here only.
double wrap_angle(double angle);

bool is_finite(const Pose& pose);

}  // namespace robsim
