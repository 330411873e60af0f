#include "robsim/base/geometry.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace robsim {

double wrap_far_angle(double angle) {
  const double wrapped = std::remainder(angle, 2 * pi);
  return wrapped <= -pi ? pi : wrapped;
}

namespace {

constexpr std::size_t most_points = 1000;
constexpr double farthest = 1e9;  // px: areas are finite, and corners told apart

double cross(const Point& a, const Point& b) { return a.x * b.y - b.x * a.y; }

// Relative to the first corner: the products stay small and exact far from the origin.
Point relative(const Polygon& polygon, std::size_t i) {
  return {polygon[i].x - polygon[0].x, polygon[i].y - polygon[0].y};
}

// Of a polygon that does not cross itself it does; of another one it may be anywhere.
bool holds_its_centroid(const Polygon& polygon) {
  const auto is_between = [&](double Point::* part) {
    const auto [least, most] =
        std::minmax_element(polygon.begin(), polygon.end(),
                            [&](const Point& a, const Point& b) { return a.*part < b.*part; });
    const double value = polygon_centroid(polygon).*part;
    const double rounding = 1e-6 * (1 + (*most).*part - (*least).*part);
    return value >= (*least).*part - rounding && value <= (*most).*part + rounding;
  };
  return is_between(&Point::x) && is_between(&Point::y);
}

}  // namespace

void check_polygon(const Polygon& polygon, const std::string& name) {
  const std::string count = std::to_string(polygon.size());
  const auto require = [&](bool holds, const std::string& what, const std::string& got) {
    if (!holds) throw std::invalid_argument(name + " must be a polygon " + what + ", got " + got);
  };
  require(polygon.size() >= 3, "of at least 3 points", count);
  require(polygon.size() <= most_points, "of at most " + std::to_string(most_points) + " points",
          count);
  for (const Point& point : polygon) {
    require(std::isfinite(point.x) && std::isfinite(point.y), "of finite points", "NaN or inf");
    require(std::max(std::abs(point.x), std::abs(point.y)) <= farthest, "of points within 1e9 px",
            "a point beyond");
  }
  require(polygon_area(polygon) >= 1e-9, "with an area",
          count + " points on a line, or sides that cross");
  require(holds_its_centroid(polygon), "whose sides do not cross",
          count + " points whose centroid is far from them");
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
