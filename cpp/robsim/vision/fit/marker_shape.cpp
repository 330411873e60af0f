#include "robsim/vision/fit/marker_shape.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace robsim {

namespace {

struct Bounds {
  Point least, most;
};

Bounds bounds_of(const Polygon& polygon) {
  Bounds bounds{polygon.front(), polygon.front()};
  for (const Point& corner : polygon) {
    bounds.least = {std::min(bounds.least.x, corner.x), std::min(bounds.least.y, corner.y)};
    bounds.most = {std::max(bounds.most.x, corner.x), std::max(bounds.most.y, corner.y)};
  }
  return bounds;
}

double squared_distance(const Point& place, const Point& a, const Point& b) {
  const Point along{b.x - a.x, b.y - a.y};
  const Point away{place.x - a.x, place.y - a.y};
  const double length = along.x * along.x + along.y * along.y;
  const double share = length > 0 ? (away.x * along.x + away.y * along.y) / length : 0;
  const double nearest = std::clamp(share, 0.0, 1.0);
  const double x = away.x - nearest * along.x;
  const double y = away.y - nearest * along.y;
  return x * x + y * y;
}

// Whether the edge from a to b is crossed on the way from a place to the right.
bool is_crossed(const Point& place, const Point& a, const Point& b) {
  if ((a.y > place.y) == (b.y > place.y)) return false;
  return place.x < a.x + (place.y - a.y) * (b.x - a.x) / (b.y - a.y);
}

double signed_distance(const Polygon& polygon, const Point& place) {
  double least = std::numeric_limits<double>::infinity();
  bool is_inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point& a = polygon[i];
    const Point& b = polygon[(i + 1) % polygon.size()];
    least = std::min(least, squared_distance(place, a, b));
    is_inside = is_inside != is_crossed(place, a, b);
  }
  return is_inside ? std::sqrt(least) : -std::sqrt(least);
}

}  // namespace

MarkerShape::MarkerShape(Polygon polygon, const std::string& name) : polygon_(std::move(polygon)) {
  check_polygon(polygon_, name);
  centroid_ = polygon_centroid(polygon_);
  for (std::size_t i = 0; i < polygon_.size(); ++i) {
    perimeter_ += std::sqrt(squared_distance(polygon_[i], polygon_[(i + 1) % polygon_.size()],
                                             polygon_[(i + 1) % polygon_.size()]));
  }
}

MarkerShape::Table::Table(const Polygon& polygon) {
  const auto [least, most] = bounds_of(polygon);
  const double width = std::max(most.x - least.x, most.y - least.y);
  left_ = (least.x + most.x) / 2 - 1.5 * width;
  top_ = (least.y + most.y) / 2 - 1.5 * width;
  per_px_ = cells / (3 * width);
  const auto distance = [&](int i, int j) {
    return signed_distance(polygon, {left_ + i / per_px_, top_ + j / per_px_});
  };
  std::vector<double> above, below(cells + 1);
  for (int i = 0; i <= cells; ++i) below[static_cast<std::size_t>(i)] = distance(i, 0);
  cells_.reserve(static_cast<std::size_t>(cells) * cells);
  for (int j = 0; j < cells; ++j) {
    above = below;
    for (int i = 0; i <= cells; ++i) below[static_cast<std::size_t>(i)] = distance(i, j + 1);
    for (std::size_t i = 0; i < cells; ++i) {
      // from the four corners of the cell
      const double a = above[i], b = above[i + 1], c = below[i], d = below[i + 1];
      cells_.push_back({static_cast<float>((a + b + c + d) / 4),
                        static_cast<float>((b + d - a - c) / 2 * per_px_),
                        static_cast<float>((c + d - a - b) / 2 * per_px_), 0});
    }
  }
}

const MarkerShape::Table& MarkerShape::table() const {
  std::call_once(once_, [&] { table_.emplace_back(polygon_); });
  return table_.front();
}

}  // namespace robsim
