#include "robsim/vision/locate.hpp"

#include <cmath>
#include <stdexcept>

namespace robsim {

namespace {

// Misfit (0 = perfect, 3 = just accepted) by which the best pair must be better than the second.
constexpr double clear_lead = 0.1;

struct Marker {
  Point position;  // work-area px
  double area;     // work-area px^2
};

std::vector<Marker> markers_of(const BlobsByColor& blobs, const char* color, const PlaneMap& map) {
  std::vector<Marker> result;
  const auto found = blobs.find(color);
  if (found == blobs.end()) return result;
  for (const Blob& blob : found->second) {
    if (blob.at_border) continue;
    const double area = static_cast<double>(blob.area) * map.area_scale(blob.centroid);
    result.push_back({map.to_world(blob.centroid), area});
  }
  return result;
}

// ((distance - expected)/tolerance)^2, 1 at the limit
double distance_misfit(const Marker& red, const Marker& blue, const MarkerLayout& markers) {
  const double expected = markers.distance();
  const double distance =
      std::hypot(red.position.x - blue.position.x, red.position.y - blue.position.y);
  return std::pow((distance - expected) / (markers.distance_tolerance * expected), 2);
}

// (log(area/expected) / log(tolerance))^2, 1 at the limit
double area_misfit(double area, double expected, const MarkerLayout& markers) {
  return std::pow(std::log(area / expected) / std::log(markers.area_tolerance), 2);
}

std::optional<double> misfit(const Marker& red, const Marker& blue, const MarkerLayout& markers) {
  const double limits[] = {
      distance_misfit(red, blue, markers),
      area_misfit(red.area, std::isnan(markers.red_area) ? blue.area : markers.red_area, markers),
      area_misfit(blue.area, std::isnan(markers.blue_area) ? red.area : markers.blue_area,
                  markers)};
  double sum = 0;
  for (const double value : limits) {
    if (!(value <= 1)) return std::nullopt;
    sum += value;
  }
  return sum;
}

// The markers' line gives the heading, their midpoint and the heading give the centre.
Pose pose_from(const Marker& red, const Marker& blue, const MarkerLayout& markers) {
  const auto direction = [](const Point& from, const Point& to) {
    return std::atan2(to.y - from.y, to.x - from.x);
  };
  const double heading =
      wrap_angle(direction(blue.position, red.position) - direction(markers.blue, markers.red));
  // centre = midpoint seen - R(heading) midpoint in the robot's frame
  const double x = (markers.red.x + markers.blue.x) / 2;
  const double y = (markers.red.y + markers.blue.y) / 2;
  const double cos = std::cos(heading);
  const double sin = std::sin(heading);
  return {(red.position.x + blue.position.x) / 2 - (x * cos - y * sin),
          (red.position.y + blue.position.y) / 2 - (x * sin + y * cos), heading};
}

}  // namespace

MarkerLayout MarkerLayout::across(double distance, double offset) {
  if (!(distance > 0)) {
    throw std::invalid_argument("distance between the markers must be above 0 px, got " +
                                std::to_string(distance));
  }
  MarkerLayout markers;
  markers.red = {-offset, distance / 2};
  markers.blue = {-offset, -distance / 2};
  check_marker_layout(markers);
  return markers;
}

MarkerLayout MarkerLayout::from_markers(const Polygon& red, const Polygon& blue) {
  check_polygon(red, "red");
  check_polygon(blue, "blue");
  MarkerLayout markers;
  markers.red = polygon_centroid(red);
  markers.blue = polygon_centroid(blue);
  markers.red_area = polygon_area(red);
  markers.blue_area = polygon_area(blue);
  check_marker_layout(markers);
  return markers;
}

double MarkerLayout::distance() const { return std::hypot(red.x - blue.x, red.y - blue.y); }

double MarkerLayout::offset() const { return -(red.x + blue.x) / 2; }

void check_marker_layout(const MarkerLayout& markers) {
  if (!std::isfinite(markers.offset()) || !std::isfinite(markers.distance())) {
    throw std::invalid_argument("distance and offset must be finite (work-area px)");
  }
  if (markers.distance() < 1e-3) {
    throw std::invalid_argument("distance between the markers must be at least 0.001 px, got " +
                                std::to_string(markers.distance()));
  }
  for (const double area : {markers.red_area, markers.blue_area}) {
    if (!std::isnan(area) && !(std::isfinite(area) && area > 0)) {
      throw std::invalid_argument("marker area must be positive and finite, or NaN, got " +
                                  std::to_string(area));
    }
  }
  if (markers.maximum_blobs < 1) {
    throw std::invalid_argument("maximum_blobs must be at least 1, got " +
                                std::to_string(markers.maximum_blobs));
  }
  if (!(markers.distance_tolerance > 0)) {
    throw std::invalid_argument("distance_tolerance must be above 0, got " +
                                std::to_string(markers.distance_tolerance));
  }
  if (!(markers.area_tolerance > 1)) {
    throw std::invalid_argument("area_tolerance must be above 1, got " +
                                std::to_string(markers.area_tolerance));
  }
}

std::optional<Measurement> locate(const BlobsByColor& blobs, const MarkerLayout& markers,
                                  const PlaneMap& plane_map) {
  const std::vector<Marker> blues = markers_of(blobs, "blue", plane_map);
  std::optional<Measurement> best;
  double best_misfit = 0;
  double second = std::numeric_limits<double>::infinity();
  for (const Marker& red : markers_of(blobs, "red", plane_map)) {
    for (const Marker& blue : blues) {
      const std::optional<double> value = misfit(red, blue, markers);
      if (!value) continue;
      if (best && *value >= best_misfit) {
        second = std::min(second, *value);
        continue;
      }
      if (best) second = best_misfit;
      best = Measurement{pose_from(red, blue, markers)};
      best_misfit = *value;
    }
  }
  if (best && second - best_misfit < clear_lead) return std::nullopt;
  return best;
}

}  // namespace robsim
