#include "robsim/vision/locate.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "robsim/elementary/exponential.hpp"
#include "robsim/elementary/polar.hpp"
#include "robsim/elementary/sine.hpp"
#include "robsim/text/to_text.hpp"

namespace robsim {

namespace {

// Misfit (0 = perfect, 3 = just accepted) by which the best pair must be better than the second.
constexpr double clear_lead = 0.1;

// Pairs by chance that may be expected in a frame.
constexpr double most_false_alarms = 0.005;

// Blobs of a colour, the largest first, among which the pair most like the markers is looked for.
constexpr std::size_t most_alike = 8;

// A blob on the work area.
struct Marker {
  const Blob* blob;
  Point position;  // work-area px
  double area;     // work-area px^2
};

struct Pair {
  Marker red;
  Marker blue;
};

Marker marker_of(const Blob& blob, const PlaneMap& map) {
  const double area = static_cast<double>(blob.area) * map.area_scale(blob.centroid);
  return {&blob, map.to_world(blob.centroid), area};
}

// The blobs of a colour that are not cut off by the border.
std::vector<Marker> markers_of(const BlobsByColor& blobs, const char* color, const PlaneMap& map) {
  std::vector<Marker> result;
  const auto found = blobs.find(color);
  if (found == blobs.end()) return result;
  for (const Blob& blob : found->second) {
    if (blob.at_border) continue;
    const Marker marker = marker_of(blob, map);
    if (std::isnan(marker.position.x)) continue;  // where the lens shows nothing
    result.push_back(marker);
  }
  return result;
}

// (log(area/expected) / log(tolerance))^2, 1 at the limit
double area_misfit(double area, double expected, const MarkerLayout& markers) {
  const double deviation =
      elementary::log(area / expected) / elementary::log(markers.area_tolerance);
  return deviation * deviation;
}

// Those with the area of the marker, or all if it is not known.
std::vector<Marker> of_area(const std::vector<Marker>& all, double expected,
                            const MarkerLayout& markers) {
  if (std::isnan(expected)) return all;
  std::vector<Marker> result;
  std::copy_if(all.begin(), all.end(), std::back_inserter(result), [&](const Marker& marker) {
    return area_misfit(marker.area, expected, markers) <= 1;
  });
  return result;
}

bool has_blobs(const BlobsByColor& blobs, const char* color) {
  const auto found = blobs.find(color);
  return found != blobs.end() && !found->second.empty();
}

double distance_of(const Pair& pair) {
  const Point &red = pair.red.position, &blue = pair.blue.position;
  return elementary::hypot(red.x - blue.x, red.y - blue.y);
}

// ((distance - expected)/tolerance)^2, 1 at the limit
double distance_misfit(const Pair& pair, const MarkerLayout& markers) {
  const double expected = markers.distance();
  const double deviation = (distance_of(pair) - expected) / (markers.distance_tolerance * expected);
  return deviation * deviation;
}

// Without a known area a marker is to be as large as the other one.
double red_misfit(const Pair& pair, const MarkerLayout& markers) {
  const bool is_known = !std::isnan(markers.red_area);
  return area_misfit(pair.red.area, is_known ? markers.red_area : pair.blue.area, markers);
}

double blue_misfit(const Pair& pair, const MarkerLayout& markers) {
  const bool is_known = !std::isnan(markers.blue_area);
  return area_misfit(pair.blue.area, is_known ? markers.blue_area : pair.red.area, markers);
}

double misfit(const Pair& pair, const MarkerLayout& markers) {
  return distance_misfit(pair, markers) + red_misfit(pair, markers) + blue_misfit(pair, markers);
}

// The misfit of a pair within all limits.
std::optional<double> accepted_misfit(const Pair& pair, const MarkerLayout& markers) {
  double sum = 0;
  for (const auto deviation : {distance_misfit, red_misfit, blue_misfit}) {
    const double value = deviation(pair, markers);
    if (!(value <= 1)) return std::nullopt;
    sum += value;
  }
  return sum;
}

// How far a pair is from the markers in scale: unlike the misfit, it weighs distance and areas
// alike, so that large blobs far apart are not passed over for specks that happen to be near.
double unlikeness(const Pair& pair, const MarkerLayout& markers) {
  // log(area/expected) = 2 log(length/expected)
  const double log_distance = 2 * elementary::log(distance_of(pair) / markers.distance()) /
                              elementary::log(markers.area_tolerance);
  return log_distance * log_distance + red_misfit(pair, markers) + blue_misfit(pair, markers);
}

// The markers' line gives the heading, their midpoint and the heading give the centre.
Pose pose_from(const Pair& pair, const MarkerLayout& markers) {
  const auto& [red, blue] = pair;
  const auto direction = [](const Point& from, const Point& to) {
    return elementary::atan2(to.y - from.y, to.x - from.x);
  };
  const double heading =
      wrap_angle(direction(blue.position, red.position) - direction(markers.blue, markers.red));
  // centre = midpoint seen - R(heading) midpoint in the robot's frame
  const double x = (markers.red.x + markers.blue.x) / 2;
  const double y = (markers.red.y + markers.blue.y) / 2;
  const auto [sin, cos] = elementary::sin_cos(heading);
  return {(red.position.x + blue.position.x) / 2 - (x * cos - y * sin),
          (red.position.y + blue.position.y) / 2 - (x * sin + y * cos), heading};
}

// Where the centroid of a marker is on the work area. The centroid of what a camera sees of it lies
// nearer to where the scale is larger, by second-order terms, which four points with the second
// moments of a disc of its area give.
Point centroid_of(const Marker& marker, const PlaneMap& map) {
  const auto& [x, y] = marker.position;
  // E[dx^2] = E[dy^2] = area / (4 pi)
  const double away = std::sqrt(marker.area / (2 * pi));
  Point sum;
  double weights = 0;
  for (const Point& place :
       {Point{x + away, y}, Point{x - away, y}, Point{x, y + away}, Point{x, y - away}}) {
    const Point pixel = map.to_pixel(place);
    const double weight = 1 / map.area_scale(pixel);
    sum = {sum.x + weight * pixel.x, sum.y + weight * pixel.y};
    weights += weight;
  }
  const Point seen = map.to_world({sum.x / weights, sum.y / weights});
  return std::isfinite(seen.x) ? Point{2 * x - seen.x, 2 * y - seen.y} : marker.position;
}

Pose pose_from(Pair pair, const MarkerLayout& markers, const PlaneMap& map) {
  if (map.intrinsics()) {
    for (Marker* marker : {&pair.red, &pair.blue}) marker->position = centroid_of(*marker, map);
  }
  return pose_from(pair, markers);
}

MarkerLayout exchanged(MarkerLayout markers) {
  std::swap(markers.red_area, markers.blue_area);
  return markers;
}

Detection detection_of(const Pair& pair, DetectionResult result, const MarkerLayout& markers) {
  Detection detection;
  detection.result = result;
  detection.red = *pair.red.blob;
  detection.blue = *pair.blue.blob;
  detection.misfit = misfit(pair, markers);
  detection.exchanged = misfit(pair, exchanged(markers));
  detection.distance = distance_of(pair);
  detection.red_area = pair.red.area;
  detection.blue_area = pair.blue.area;
  return detection;
}

// Why no pair is accepted, by the pair most like the markers.
Detection refused(const std::vector<Marker>& reds, const std::vector<Marker>& blues,
                  const MarkerLayout& markers) {
  Pair nearest{reds.front(), blues.front()};
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::min(reds.size(), most_alike); ++i) {
    for (std::size_t j = 0; j < std::min(blues.size(), most_alike); ++j) {
      const Pair pair{reds[i], blues[j]};
      const double value = unlikeness(pair, markers);
      if (value < least) {
        least = value;
        nearest = pair;
      }
    }
  }
  const bool is_near = distance_misfit(nearest, markers) <= 1;
  return detection_of(nearest, is_near ? DetectionResult::areas : DetectionResult::distance,
                      markers);
}

// Why there is no pair at all.
DetectionResult without_pair(const BlobsByColor& blobs) {
  const bool has_red = has_blobs(blobs, "red");
  const bool has_blue = has_blobs(blobs, "blue");
  if (has_red && has_blue) return DetectionResult::at_border;
  if (has_red) return DetectionResult::no_blue_blob;
  return has_blue ? DetectionResult::no_red_blob : DetectionResult::no_blobs;
}

// The area that the blobs are spread over (px^2): their extent, which falls short of that of the
// floor by a factor of (n - 1)/(n + 1) in each direction if n blobs lie anywhere, and which is no
// less than that of a robot.
double spread(const std::vector<Marker>& reds, const std::vector<Marker>& blues, double robot) {
  const Point& first = reds.front().position;
  Point least = first;
  Point most = first;
  for (const std::vector<Marker>* markers : {&reds, &blues}) {
    for (const Marker& marker : *markers) {
      const Point& place = marker.position;
      least = {std::min(least.x, place.x), std::min(least.y, place.y)};
      most = {std::max(most.x, place.x), std::max(most.y, place.y)};
    }
  }
  const auto count = static_cast<double>(reds.size() + blues.size());
  const double factor = (count + 1) / (count - 1);
  return std::max(factor * (most.x - least.x), robot) *
         std::max(factor * (most.y - least.y), robot);
}

// How many pairs of blobs that are not in the best pair would fit as well as that one, if they lay
// anywhere: the sum of the probabilities that their distance does.
double false_alarms(const Pair& best, double best_misfit, const std::vector<Marker>& reds,
                    const std::vector<Marker>& blues, const MarkerLayout& markers) {
  double sum = 0;
  for (const Marker& red : reds) {
    if (red.blob == best.red.blob) continue;
    for (const Marker& blue : blues) {
      if (blue.blob == best.blue.blob) continue;
      const Pair pair{red, blue};
      const double rest = best_misfit - red_misfit(pair, markers) - blue_misfit(pair, markers);
      if (rest > 0) sum += std::sqrt(std::min(rest, 1.0));
    }
  }
  // area of the ring: 2 pi distance x 2 tolerance distance sqrt(rest)
  const double distance = markers.distance();
  const double ring = 4 * pi * markers.distance_tolerance * distance * distance;
  return sum == 0 ? 0 : sum * ring / spread(reds, blues, markers.distance());
}

Detection choose(const BlobsByColor& blobs, const MarkerLayout& markers, const PlaneMap& map) {
  const std::vector<Marker> reds = markers_of(blobs, "red", map);
  const std::vector<Marker> blues = markers_of(blobs, "blue", map);
  Detection none;
  none.result = without_pair(blobs);
  if (reds.empty() || blues.empty()) return none;
  const std::vector<Marker> red_candidates = of_area(reds, markers.red_area, markers);
  const std::vector<Marker> blue_candidates = of_area(blues, markers.blue_area, markers);
  std::optional<Pair> best;
  double best_misfit = 0;
  double second = std::numeric_limits<double>::infinity();
  for (const Marker& red : red_candidates) {
    for (const Marker& blue : blue_candidates) {
      const std::optional<double> value = accepted_misfit({red, blue}, markers);
      if (!value) continue;
      if (best && *value >= best_misfit) {
        second = std::min(second, *value);
        continue;
      }
      if (best) second = best_misfit;
      best = Pair{red, blue};
      best_misfit = *value;
    }
  }
  if (!best) return refused(reds, blues, markers);
  Detection detection = detection_of(*best, DetectionResult::detected, markers);
  detection.runner_up = second;
  detection.false_alarms =
      false_alarms(*best, best_misfit, red_candidates, blue_candidates, markers);
  if (second - best_misfit < clear_lead) {
    detection.result = DetectionResult::ambiguous;
  } else if (detection.false_alarms > most_false_alarms) {
    detection.result = DetectionResult::by_chance;
  } else {
    detection.measurement = Measurement{};
    detection.measurement->pose = pose_from(*best, markers, map);
    detection.measurement->pair = MarkerPair{*detection.red, *detection.blue};
  }
  return detection;
}

}  // namespace

MarkerLayout MarkerLayout::across(double distance, double offset) {
  if (!(distance > 0)) {
    throw std::invalid_argument("distance between the markers must be above 0 px, got " +
                                to_text(distance));
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
  markers.red_shape = std::make_shared<MarkerShape>(red, "red");
  markers.blue_shape = std::make_shared<MarkerShape>(blue, "blue");
  check_marker_layout(markers);
  return markers;
}

double MarkerLayout::distance() const { return elementary::hypot(red.x - blue.x, red.y - blue.y); }

double MarkerLayout::offset() const { return -(red.x + blue.x) / 2; }

namespace {

// An outline must be that of the marker, and come with that of the other one.
void check_outline(const MarkerShape* shape, const Point& place, const char* name,
                   const MarkerLayout& markers) {
  if (!markers.red_shape && !markers.blue_shape) return;
  const std::string polygon = std::string(name) + "_polygon";
  if (!shape) {
    throw std::invalid_argument(polygon + " must be given if that of the other marker is");
  }
  const Point& centroid = shape->centroid();
  const double beside = elementary::hypot(centroid.x - place.x, centroid.y - place.y);
  if (!(beside <= std::max(0.5, 0.05 * markers.distance()))) {
    throw std::invalid_argument(polygon + " must have its centroid at the marker, got one " +
                                to_text(beside) + " px away");
  }
}

}  // namespace

void check_marker_layout(const MarkerLayout& markers) {
  if (!std::isfinite(markers.offset()) || !std::isfinite(markers.distance())) {
    throw std::invalid_argument("distance and offset must be finite (work-area px)");
  }
  if (markers.distance() < 1e-3) {
    throw std::invalid_argument("distance between the markers must be at least 0.001 px, got " +
                                to_text(markers.distance()));
  }
  for (const double area : {markers.red_area, markers.blue_area}) {
    if (!std::isnan(area) && !(std::isfinite(area) && area > 0)) {
      throw std::invalid_argument("marker area must be positive and finite, or NaN, got " +
                                  to_text(area));
    }
  }
  check_outline(markers.red_shape.get(), markers.red, "red", markers);
  check_outline(markers.blue_shape.get(), markers.blue, "blue", markers);
  if (markers.maximum_blobs < 1) {
    throw std::invalid_argument("maximum_blobs must be at least 1, got " +
                                std::to_string(markers.maximum_blobs));
  }
  if (!(markers.distance_tolerance > 0)) {
    throw std::invalid_argument("distance_tolerance must be above 0, got " +
                                to_text(markers.distance_tolerance));
  }
  if (!(markers.area_tolerance > 1)) {
    throw std::invalid_argument("area_tolerance must be above 1, got " +
                                to_text(markers.area_tolerance));
  }
}

Detection detect(const BlobsByColor& blobs, const MarkerLayout& markers,
                 const PlaneMap& plane_map) {
  Detection detection = choose(blobs, markers, plane_map);
  detection.markers = markers;
  return detection;
}

Pose pose_of(const MarkerPair& pair, const MarkerLayout& markers, const PlaneMap& plane_map) {
  return pose_from({marker_of(pair.red, plane_map), marker_of(pair.blue, plane_map)}, markers,
                   plane_map);
}

}  // namespace robsim
