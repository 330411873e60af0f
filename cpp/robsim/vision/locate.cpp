#include "robsim/vision/locate.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/system.hpp"

namespace robsim {

namespace {

// Misfit (0 = perfect, 3 = just accepted) by which the best pair must be better than the second.
constexpr double clear_lead = 0.1;

// Pairs by chance that may be expected in a frame.
constexpr double most_false_alarms = 0.005;

// Blobs of a colour, the largest first, among which the pair most like the markers is looked for.
constexpr std::size_t most_alike = 8;

// A blob on the work area.
struct Candidate {
  const Blob* blob;
  Point position;  // work-area px
  double area;     // work-area px^2
};

struct Pair {
  Candidate first;
  Candidate second;
};

Candidate candidate_of(const Blob& blob, const PlaneMap& map) {
  const double area = static_cast<double>(blob.area) * map.area_scale(blob.centroid);
  return {&blob, map.to_world(blob.centroid), area};
}

// Of so many blobs of a colour, the largest, those that are not cut off by the border.
std::vector<Candidate> candidates_of(const BlobsByColor& blobs, const std::string& color,
                                     const PlaneMap& map, int most) {
  std::vector<Candidate> result;
  const auto found = blobs.find(color);
  if (found == blobs.end()) return result;
  const auto count = std::min(found->second.size(), static_cast<std::size_t>(most));
  for (std::size_t i = 0; i < count; ++i) {
    const Blob& blob = found->second[i];
    if (blob.at_border) continue;
    const Candidate marker = candidate_of(blob, map);
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
std::vector<Candidate> of_area(const std::vector<Candidate>& all, double expected,
                               const MarkerLayout& markers) {
  if (std::isnan(expected)) return all;
  std::vector<Candidate> result;
  std::copy_if(all.begin(), all.end(), std::back_inserter(result), [&](const Candidate& marker) {
    return area_misfit(marker.area, expected, markers) <= 1;
  });
  return result;
}

bool has_blobs(const BlobsByColor& blobs, const std::string& color) {
  const auto found = blobs.find(color);
  return found != blobs.end() && !found->second.empty();
}

double distance_of(const Pair& pair) {
  const Point &first = pair.first.position, &second = pair.second.position;
  return elementary::hypot(first.x - second.x, first.y - second.y);
}

// ((distance - expected)/tolerance)^2, 1 at the limit
double distance_misfit(const Pair& pair, const MarkerLayout& markers) {
  const double expected = markers.distance();
  const double deviation = (distance_of(pair) - expected) / (markers.distance_tolerance * expected);
  return deviation * deviation;
}

// Without a known area a marker is to be as large as the other one.
double first_misfit(const Pair& pair, const MarkerLayout& markers) {
  const bool is_known = !std::isnan(markers.first.area);
  return area_misfit(pair.first.area, is_known ? markers.first.area : pair.second.area, markers);
}

double second_misfit(const Pair& pair, const MarkerLayout& markers) {
  const bool is_known = !std::isnan(markers.second.area);
  return area_misfit(pair.second.area, is_known ? markers.second.area : pair.first.area, markers);
}

double misfit(const Pair& pair, const MarkerLayout& markers) {
  return distance_misfit(pair, markers) + first_misfit(pair, markers) +
         second_misfit(pair, markers);
}

// The misfit of a pair within all limits.
std::optional<double> accepted_misfit(const Pair& pair, const MarkerLayout& markers) {
  double sum = 0;
  for (const auto deviation : {distance_misfit, first_misfit, second_misfit}) {
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
  return log_distance * log_distance + first_misfit(pair, markers) + second_misfit(pair, markers);
}

// The markers' line gives the heading, their midpoint and the heading give the centre.
Pose pose_from(const Pair& pair, const MarkerLayout& markers) {
  const auto& [first, second] = pair;
  const auto direction = [&](const Point& one, const Point& other) {
    const bool is_first = markers.is_first_farther_right();
    const Point &to = is_first ? one : other, &from = is_first ? other : one;
    return elementary::atan2(to.y - from.y, to.x - from.x);
  };
  const double heading = wrap_angle(direction(first.position, second.position) -
                                    direction(markers.first.position, markers.second.position));
  // centre = midpoint seen - R(heading) midpoint in the robot's frame
  const double x = (markers.first.position.x + markers.second.position.x) / 2;
  const double y = (markers.first.position.y + markers.second.position.y) / 2;
  const auto [sin, cos] = elementary::sin_cos(heading);
  return {(first.position.x + second.position.x) / 2 - (x * cos - y * sin),
          (first.position.y + second.position.y) / 2 - (x * sin + y * cos), heading};
}

// Where the centroid of a marker is on the work area. The centroid of what a camera sees of it lies
// nearer to where the scale is larger, by second-order terms, which four points with the second
// moments of a disc of its area give.
Point centroid_of(const Candidate& marker, const PlaneMap& map) {
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
    for (Candidate* marker : {&pair.first, &pair.second})
      marker->position = centroid_of(*marker, map);
  }
  return pose_from(pair, markers);
}

MarkerLayout exchanged(MarkerLayout markers) {
  std::swap(markers.first.area, markers.second.area);
  return markers;
}

Detection detection_of(const Pair& pair, DetectionResult result, const MarkerLayout& markers) {
  Detection detection;
  detection.result = result;
  detection.first = *pair.first.blob;
  detection.second = *pair.second.blob;
  detection.misfit = misfit(pair, markers);
  detection.exchanged = misfit(pair, exchanged(markers));
  detection.distance = distance_of(pair);
  detection.first_area = pair.first.area;
  detection.second_area = pair.second.area;
  return detection;
}

// Why no pair is accepted, by the pair most like the markers.
Detection refused(const std::vector<Candidate>& firsts, const std::vector<Candidate>& seconds,
                  const MarkerLayout& markers) {
  Pair nearest{firsts.front(), seconds.front()};
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::min(firsts.size(), most_alike); ++i) {
    for (std::size_t j = 0; j < std::min(seconds.size(), most_alike); ++j) {
      const Pair pair{firsts[i], seconds[j]};
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
DetectionResult without_pair(const BlobsByColor& blobs, const MarkerLayout& markers) {
  const bool has_first = has_blobs(blobs, markers.first.color);
  const bool has_second = has_blobs(blobs, markers.second.color);
  if (has_first && has_second) return DetectionResult::at_border;
  if (has_first) return DetectionResult::no_second_blob;
  return has_second ? DetectionResult::no_first_blob : DetectionResult::no_blobs;
}

// The area that the blobs are spread over (px^2): their extent, which falls short of that of the
// floor by a factor of (n - 1)/(n + 1) in each direction if n blobs lie anywhere, and which is no
// less than that of a robot.
double spread(const std::vector<Candidate>& firsts, const std::vector<Candidate>& seconds,
              double robot) {
  const Point& start = firsts.front().position;
  Point least = start;
  Point most = start;
  for (const std::vector<Candidate>* markers : {&firsts, &seconds}) {
    for (const Candidate& marker : *markers) {
      const Point& place = marker.position;
      least = {std::min(least.x, place.x), std::min(least.y, place.y)};
      most = {std::max(most.x, place.x), std::max(most.y, place.y)};
    }
  }
  const auto count = static_cast<double>(firsts.size() + seconds.size());
  const double factor = (count + 1) / (count - 1);
  return std::max(factor * (most.x - least.x), robot) *
         std::max(factor * (most.y - least.y), robot);
}

// How many pairs of blobs that are not in the best pair would fit as well as that one, if they lay
// anywhere: the sum of the probabilities that their distance does.
double false_alarms(const Pair& best, double best_misfit, const std::vector<Candidate>& firsts,
                    const std::vector<Candidate>& seconds, const MarkerLayout& markers) {
  double sum = 0;
  for (const Candidate& first : firsts) {
    if (first.blob == best.first.blob) continue;
    for (const Candidate& second : seconds) {
      if (second.blob == best.second.blob) continue;
      const Pair pair{first, second};
      const double rest = best_misfit - first_misfit(pair, markers) - second_misfit(pair, markers);
      if (rest > 0) sum += std::sqrt(std::min(rest, 1.0));
    }
  }
  // area of the ring: 2 pi distance x 2 tolerance distance sqrt(rest)
  const double distance = markers.distance();
  const double ring = 4 * pi * markers.distance_tolerance * distance * distance;
  return sum == 0 ? 0 : sum * ring / spread(firsts, seconds, markers.distance());
}

Detection choose(const BlobsByColor& blobs, const MarkerLayout& markers, const PlaneMap& map) {
  const std::vector<Candidate> firsts =
      candidates_of(blobs, markers.first.color, map, markers.maximum_blobs);
  const std::vector<Candidate> seconds =
      candidates_of(blobs, markers.second.color, map, markers.maximum_blobs);
  Detection none;
  none.result = without_pair(blobs, markers);
  if (firsts.empty() || seconds.empty()) return none;
  const std::vector<Candidate> first_candidates = of_area(firsts, markers.first.area, markers);
  const std::vector<Candidate> second_candidates = of_area(seconds, markers.second.area, markers);
  std::optional<Pair> best;
  double best_misfit = 0;
  double runner_up = std::numeric_limits<double>::infinity();
  for (const Candidate& first : first_candidates) {
    for (const Candidate& second : second_candidates) {
      const std::optional<double> value = accepted_misfit({first, second}, markers);
      if (!value) continue;
      if (best && *value >= best_misfit) {
        runner_up = std::min(runner_up, *value);
        continue;
      }
      if (best) runner_up = best_misfit;
      best = Pair{first, second};
      best_misfit = *value;
    }
  }
  if (!best) return refused(firsts, seconds, markers);
  Detection detection = detection_of(*best, DetectionResult::detected, markers);
  detection.runner_up = runner_up;
  detection.false_alarms =
      false_alarms(*best, best_misfit, first_candidates, second_candidates, markers);
  if (runner_up - best_misfit < clear_lead) {
    detection.result = DetectionResult::ambiguous;
  } else if (detection.false_alarms > most_false_alarms) {
    detection.result = DetectionResult::by_chance;
  } else {
    detection.measurement = Measurement{};
    detection.measurement->pose = pose_from(*best, markers, map);
    detection.measurement->pair = MarkerPair{*detection.first, *detection.second, markers.roles};
  }
  return detection;
}

Marker marker_from(const Polygon& polygon, const std::string& color, const std::string& role) {
  check_polygon(polygon, role);
  return {color, polygon_centroid(polygon), polygon_area(polygon),
          std::make_shared<MarkerShape>(polygon, role)};
}

}  // namespace

MarkerLayout MarkerLayout::across(double distance, double offset,
                                  const std::array<std::string, 2>& colors) {
  checked(distance, distance > 0, "distance between the markers must be above 0 px");
  MarkerLayout markers;
  markers.first.color = colors[0];
  markers.second.color = colors[1];
  markers.first.position = {-offset, distance / 2};
  markers.second.position = {-offset, -distance / 2};
  check_marker_layout(markers);
  return markers;
}

MarkerLayout MarkerLayout::from_markers(const Polygon& first, const Polygon& second,
                                        const std::array<std::string, 2>& colors,
                                        MarkerRoles roles) {
  MarkerLayout markers;
  markers.roles = roles;
  markers.first = marker_from(first, colors[0], names_of(roles)[0]);
  markers.second = marker_from(second, colors[1], names_of(roles)[1]);
  check_marker_layout(markers);
  return markers;
}

double MarkerLayout::distance() const {
  const Point &to = first.position, &from = second.position;
  return elementary::hypot(to.x - from.x, to.y - from.y);
}

bool MarkerLayout::is_first_farther_right() const { return first.position.y >= second.position.y; }

double MarkerLayout::offset() const { return -(first.position.x + second.position.x) / 2; }

namespace {

// An outline must be that of the marker, and come with that of the other one.
void check_outline(const Marker& marker, const std::string& role, const MarkerLayout& markers) {
  if (!markers.first.shape && !markers.second.shape) return;
  const std::string polygon = "the polygon of the " + role + " marker";
  if (!marker.shape) {
    throw std::invalid_argument(polygon + " must be given if that of the other marker is");
  }
  const Point centroid = marker.shape->centroid();
  const double beside =
      elementary::hypot(centroid.x - marker.position.x, centroid.y - marker.position.y);
  if (!(beside <= std::max(0.5, 0.05 * markers.distance()))) {
    throw std::invalid_argument(polygon + " must have its centroid at the marker, got one " +
                                to_text(beside) + " px away");
  }
}

}  // namespace

void check_marker_layout(const MarkerLayout& markers) {
  if (markers.first.color.empty() || markers.first.color == markers.second.color ||
      markers.second.color.empty()) {
    throw std::invalid_argument("colors must be the names of two different colours, got '" +
                                markers.first.color + "' and '" + markers.second.color + "'");
  }
  if (!std::isfinite(markers.offset()) || !std::isfinite(markers.distance())) {
    throw std::invalid_argument("distance and offset must be finite (work-area px)");
  }
  checked(markers.distance(), markers.distance() >= 1e-3,
          "distance between the markers must be at least 0.001 px");
  if (const auto problem =
          contradiction(markers.roles, markers.first.position, markers.second.position)) {
    throw std::invalid_argument(*problem);
  }
  for (const double area : {markers.first.area, markers.second.area}) {
    checked(area, std::isnan(area) || (std::isfinite(area) && area > 0),
            "marker area must be positive and finite, or NaN");
  }
  const auto& [first_role, second_role] = names_of(markers.roles);
  check_outline(markers.first, first_role, markers);
  check_outline(markers.second, second_role, markers);
  checked(markers.maximum_blobs, markers.maximum_blobs >= 1, "maximum_blobs must be at least 1");
  checked(markers.distance_tolerance, markers.distance_tolerance > 0,
          "distance_tolerance must be above 0");
  checked(markers.area_tolerance, markers.area_tolerance > 1, "area_tolerance must be above 1");
}

Detection detect(const BlobsByColor& blobs, const MarkerLayout& markers,
                 const PlaneMap& plane_map) {
  Detection detection = choose(blobs, markers, plane_map);
  detection.markers = markers;
  return detection;
}

Pose pose_of(const MarkerPair& pair, const MarkerLayout& markers, const PlaneMap& plane_map) {
  return pose_from({candidate_of(pair.first, plane_map), candidate_of(pair.second, plane_map)},
                   markers, plane_map);
}

}  // namespace robsim
