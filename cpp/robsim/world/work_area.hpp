#pragma once

#include "robsim/geometry/pose.hpp"
#include "robsim/imaging/image.hpp"

namespace robsim {

/// What the robot meets at the edge of the work area.
enum class Boundary { bounce, unlimited };

/// The floor the camera looks at, in work-area px.
struct WorkArea {
  int width = 1200;
  int height = 1200;
  Boundary boundary = Boundary::bounce;
};

/// Mirrors the last two poses at every wall that the robot, `radius` px around its centre, has run
/// into on its way from `last` to `now`. True if there was one.
bool bounce(const WorkArea& area, double radius, Pose& now, Pose& last);

/// Whole camera pixels by which the view is moved over an unlimited area.
struct Pan {
  int u = 0;
  int v = 0;
};

inline bool operator==(const Pan& a, const Pan& b) { return a.u == b.u && a.v == b.v; }

/// Moves the view of width x height pixels just so far that the pixel stays `margin` pixels off
/// its edges. `pixel` is counted from the corner of the view that has not been moved.
Pan follow(const Pan& pan, const Point& pixel, int width, int height, double margin);

}  // namespace robsim
