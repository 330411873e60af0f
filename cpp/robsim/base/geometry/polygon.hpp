#pragma once

#include <string>
#include <vector>

#include "robsim/base/geometry/pose.hpp"

namespace robsim {

using Polygon = std::vector<Point>;

/// Throws std::invalid_argument, naming `name`, unless the polygon has 3 to 1000 corners within
/// 1e9 px, an area, and its centroid among its corners.
void check_polygon(const Polygon& polygon, const std::string& name);

/// Area by the shoelace formula, always positive.
double polygon_area(const Polygon& polygon);

/// Centroid of the area inside the polygon.
Point polygon_centroid(const Polygon& polygon);

}  // namespace robsim
