#pragma once

#include <limits>
#include <optional>

#include "robsim/geometry/polygon.hpp"
#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/find_blobs.hpp"

namespace robsim {

/// The pose of a detected robot.
struct Measurement {
  Pose pose;
};

/// The positions of a robot's red and blue marker: what turns a pair of blobs into a pose.
/// Positions are in the robot's frame: x forward, y to its right, from its centre (work-area px).
struct MarkerLayout {
  Point red;
  Point blue;
  double red_area = std::numeric_limits<double>::quiet_NaN();   // work-area px^2, NaN = unknown
  double blue_area = std::numeric_limits<double>::quiet_NaN();  // work-area px^2, NaN = unknown
  double distance_tolerance = 0.12;  // fraction of the distance between the markers
  double area_tolerance = 2;         // maximum ratio between an area and its expected value
  int maximum_blobs = 64;            // blobs considered per colour, the largest first

  /// The layout of the manual: the line from blue to red is perpendicular to the heading, red on
  /// the robot's right; the centre lies `offset` px ahead of its midpoint.
  static MarkerLayout across(double distance, double offset);

  /// From marker polygons in the robot's frame.
  static MarkerLayout from_markers(const Polygon& red, const Polygon& blue);

  double distance() const;  // between the two markers
  double offset() const;    // from the midpoint of the markers forward to the centre
};

/// Throws std::invalid_argument for values that are not finite, coincident markers and tolerances
/// that no pair can meet.
void check_marker_layout(const MarkerLayout& markers);

/// The pose of the robot whose markers are among the blobs: that of the red-blue pair whose
/// distance and areas fit best; nullopt if no pair fits, or two fit equally well. Blobs at the
/// border of the frame may be cut off and are not used. Without known marker areas, those of a pair
/// must be similar.
std::optional<Measurement> locate(const BlobsByColor& blobs, const MarkerLayout& markers,
                                  const PlaneMap& plane_map);

}  // namespace robsim
