#include "robsim/geometry/polygon.hpp"

#include <cmath>
#include <stdexcept>

namespace robsim {

namespace {

double cross(const Point& a, const Point& b) { return a.x * b.y - b.x * a.y; }

double signed_area(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    twice += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  }
  return twice / 2;
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

double polygon_area(const Polygon& polygon) { return std::abs(signed_area(polygon)); }

Point polygon_centroid(const Polygon& polygon) {
  // Relative to the first corner: the products stay small and exact far from the origin.
  const Point origin = polygon.front();
  double twice_area = 0;
  Point moment;
  for (std::size_t i = 0; i + 1 < polygon.size(); ++i) {
    const Point a{polygon[i].x - origin.x, polygon[i].y - origin.y};
    const Point b{polygon[i + 1].x - origin.x, polygon[i + 1].y - origin.y};
    twice_area += cross(a, b);
    moment.x += (a.x + b.x) * cross(a, b);
    moment.y += (a.y + b.y) * cross(a, b);
  }
  return {origin.x + moment.x / (3 * twice_area), origin.y + moment.y / (3 * twice_area)};
}

}  // namespace robsim
