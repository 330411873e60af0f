#pragma once

#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/fit/marker_shape.hpp"

namespace robsim::fit {

/// The error (frame px) of an edge along rows or columns of pixels, in a picture of this blur: 0
/// but where it is sharp, as the model's step is no ramp as wide as a pixel.
double grid_error(double blur);

/// The variance of the place of a marker by this error of its sides, as a share of its square. The
/// more rows or columns a side crosses, the more do its errors average out.
double grid_share(const MarkerShape& shape, const Pose& pose, const PlaneMap& map);

}  // namespace robsim::fit
