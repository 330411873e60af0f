#pragma once

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "robsim/base/geometry.hpp"
#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/find_blobs.hpp"
#include "robsim/vision/fit/pose_fit.hpp"
#include "robsim/vision/marker_roles.hpp"

namespace robsim {

/// The two blobs that were taken for the markers.
struct MarkerPair {
  Blob first;
  Blob second;
  MarkerRoles roles = MarkerRoles::right_left;
};

/// The pose of a detected robot, and how good it is, as far as that is known.
struct Measurement {
  Pose pose;
  std::optional<PoseCovariance> covariance =
      std::nullopt;  // of x, y (work-area px) and heading (rad)
  double misfit = std::numeric_limits<double>::quiet_NaN();           // NaN = unknown: see PoseFit
  double signal_to_noise = std::numeric_limits<double>::quiet_NaN();  // NaN = unknown
  std::optional<MarkerPair> pair = std::nullopt;
  double given_heading = std::numeric_limits<double>::quiet_NaN();  // of a user, before it wraps
};

/// A marker in the robot's frame: x forward, y to its right, from its centre (work-area px).
struct Marker {
  std::string color;    // name of the colour class that its blobs are of
  Point position = {};  // its centroid
  double area = std::numeric_limits<double>::quiet_NaN();  // work-area px^2, NaN = unknown
  // Its outline, if known; copies of a layout share it.
  std::shared_ptr<const MarkerShape> shape = nullptr;
};

/// The names of a robot's two colours, if no others are given.
inline const std::array<std::string, 2> default_marker_colors = {"red", "blue"};

/// The two markers of a robot: what turns a pair of blobs into a pose.
struct MarkerLayout {
  Marker first{default_marker_colors[0]};
  Marker second{default_marker_colors[1]};
  MarkerRoles roles = MarkerRoles::right_left;
  double distance_tolerance = 0.12;  // fraction of the distance between the markers
  double area_tolerance = 2.5;       // maximum ratio between an area and its expected value
  int maximum_blobs = 64;            // blobs considered per colour, the largest first

  /// The layout of the manual: the line from the left marker to the right one is perpendicular to
  /// the heading; the centre lies `offset` px ahead of its midpoint.
  static MarkerLayout across(double distance, double offset,
                             const std::array<std::string, 2>& colors = default_marker_colors);

  /// From marker polygons in the robot's frame.
  static MarkerLayout from_markers(const Polygon& first, const Polygon& second,
                                   const std::array<std::string, 2>& colors = default_marker_colors,
                                   MarkerRoles roles = MarkerRoles::right_left);

  double distance() const;  // between the two markers
  double offset() const;    // from the midpoint of the markers forward to the centre

  /// Poses are computed from that one on: so their last digits do not depend on the roles.
  bool is_first_farther_right() const;
};

/// Throws std::invalid_argument for colours without a name or of the same one, values that are not
/// finite, coincident markers, roles that contradict the positions and tolerances that no pair can
/// meet.
void check_marker_layout(const MarkerLayout& markers);

/// What the choice of a pair of blobs came to.
enum class DetectionResult {
  detected,
  no_blobs,  // of either colour
  no_first_blob,
  no_second_blob,
  at_border,  // all blobs of a colour may be cut off
  distance,   // no pair is as far apart as the markers
  areas,      // the blobs of a pair are too large or too small
  ambiguous,  // two pairs fit equally well
  by_chance,  // so many other blobs are about that a pair of them would fit as well
  noise,      // the markers' edges do not stand out of the noise

  // Causes in the frame, where it was examined.
  dark,
  overexposed,
  small_markers,

  shape  // the blobs are not like the markers' outlines
};

constexpr DetectionResult last_result = DetectionResult::shape;

/// The pair of blobs, one of each colour, that fits the markers best, how well it fits, and what
/// follows from it.
struct Detection {
  std::optional<Measurement> measurement;
  DetectionResult result = DetectionResult::no_blobs;

  // The pair: if none is accepted, the one most like the markers.
  std::optional<Blob> first;
  std::optional<Blob> second;
  double misfit = std::numeric_limits<double>::infinity();     // 0 = perfect; no pair: infinite
  double runner_up = std::numeric_limits<double>::infinity();  // of the next pair that fits, too
  double exchanged = std::numeric_limits<double>::infinity();  // if the first were the second, and
                                                               // the second the first
  double false_alarms = 0;  // pairs of the other blobs that fit as well, to be expected by chance
  double distance = 0;      // between the two blobs, work-area px
  double first_area = 0;    // work-area px^2
  double second_area = 0;   // work-area px^2

  bool by_second_chance = false;  // the pair was found relative to brightness: see MarkerVision

  // The number that tells a cause in the frame: signal to noise, mean level, share, width.
  double cause = 0;
  double noise = 0;  // of the frame (grey levels), where the markers are too small for it

  MarkerLayout markers;  // that were looked for
};

/// Looks for the pair of blobs whose distance and areas fit the markers best. The misfit is the sum
/// of three squared deviations, each at most 1 (the limit) in a pair that is accepted. Blobs at the
/// border of the frame may be cut off and are not used. Without known marker areas, those of a pair
/// must be similar. There is no measurement if no pair is accepted, or two fit equally well, or the
/// other blobs would give one as good too often by chance: in noise that takes specks of the floor
/// for markers, a false pose is to be expected in one or two of 100 frames at most.
/// Method: the number of false alarms (Desolneux, Moisan and Morel 2000, Meaningful alignments).
Detection detect(const BlobsByColor& blobs, const MarkerLayout& markers, const PlaneMap& plane_map);

/// The pose of a robot whose markers are these two blobs.
Pose pose_of(const MarkerPair& pair, const MarkerLayout& markers, const PlaneMap& plane_map);

}  // namespace robsim
