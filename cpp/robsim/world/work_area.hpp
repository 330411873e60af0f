#pragma once

#include "robsim/base/geometry.hpp"
#include "robsim/imaging/image.hpp"

namespace robsim {

/// What happens at the edge of the work area.
enum class Boundary { bounce, unlimited };

/// The floor under the camera, in work-area px.
struct WorkArea {
  int width = 1200;
  int height = 1200;
  Boundary boundary = Boundary::bounce;
};

/// Mirrors the last two poses at every wall that the robot, a disc of `radius` px, has hit between
/// `previous` and `current`. True if it hit any.
bool bounce(const WorkArea& area, double radius, Pose& current, Pose& previous);

/// Displacement of the view over an unlimited area, in whole camera pixels.
struct Pan {
  int u = 0;
  int v = 0;
};

inline bool operator==(const Pan& a, const Pan& b) { return a.u == b.u && a.v == b.v; }

/// Moves the view of width x height pixels just far enough to keep the pixel `margin` pixels away
/// from its edges. `pixel` is relative to the corner of the view before any pan.
Pan follow(const Pan& pan, const Point& pixel, int width, int height, double margin);

}  // namespace robsim
