#pragma once

#include <vector>

#include "robsim/imaging/plane_map.hpp"

namespace robsim {

/// The homography from pixels to positions with the least sum of squared distances on the work
/// area, by Gauss-Newton iterations from the linear solution; coordinates are normalised as in
/// Hartley, "In defense of the eight-point algorithm", PAMI 1997. At least five points.
/// Throws std::invalid_argument if they do not determine it, or do not belong together.
PlaneMap::Matrix fit_homography(const std::vector<Point>& pixels,
                                const std::vector<Point>& positions);

}  // namespace robsim
