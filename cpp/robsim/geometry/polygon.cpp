#include "robsim/geometry/polygon.hpp"

#include <cmath>
#include <stdexcept>

namespace robsim {

namespace {

double cross(const Point& a, const Point& b) { return a.x * b.y - b.x * a.y; }

// Relative to the first corner: the products stay small and exact far from the origin.
Point relative(const Polygon& polygon, std::size_t i) {
  return {polygon[i].x - polygon[0].x, polygon[i].y - polygon[0].y};
}

}  // namespace

void check_polygon(const Polygon& polygon, const std::string& name) {
  if (polygon.size() < 3) {
    throw std::invalid_argument(name + " must be a polygon of at least 3 points, got " +
                                std::to_string(polygon.size()));
  }
  for (const Point& point : polygon) {
    if (!std::isfinite(point.x) || !std::isfinite(point.y)) {
      throw std::invalid_argument(name + " must be a polygon of finite points, got NaN or inf");
    }
  }
  if (polygon_area(polygon) < 1e-9) {
    throw std::invalid_argument(name + " must be a polygon with an area, got " +
                                std::to_string(polygon.size()) + " points on a line");
  }
}

double polygon_area(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i + 1 < polygon.size(); ++i) {
    twice += cross(relative(polygon, i), relative(polygon, i + 1));
  }
  return std::abs(twice / 2);
}

Point polygon_centroid(const Polygon& polygon) {
  double twice_area = 0;
  Point moment;
  for (std::size_t i = 0; i + 1 < polygon.size(); ++i) {
    const Point a = relative(polygon, i);
    const Point b = relative(polygon, i + 1);
    twice_area += cross(a, b);
    moment.x += (a.x + b.x) * cross(a, b);
    moment.y += (a.y + b.y) * cross(a, b);
  }
  return {polygon[0].x + moment.x / (3 * twice_area), polygon[0].y + moment.y / (3 * twice_area)};
}

}  // namespace robsim
