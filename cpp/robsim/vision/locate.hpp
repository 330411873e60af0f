#pragma once

#include <limits>
#include <optional>

#include "robsim/geometry/polygon.hpp"
#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/find_blobs.hpp"

namespace robsim {

/// Where a robot was seen. A frame without a robot gives no Measurement at all.
struct Measurement {
  Pose pose;
};

/// Where a robot carries its red and its blue marker: what turns a pair of blobs into a pose.
/// Places are in the robot's frame: x forward, y to its right, from its centre (work-area px).
struct MarkerLayout {
  Point red;
  Point blue;
  double red_area = std::numeric_limits<double>::quiet_NaN();   // work-area px^2, NaN = not known
  double blue_area = std::numeric_limits<double>::quiet_NaN();  // work-area px^2, NaN = not known
  double distance_tolerance = 0.12;  // of the distance between the markers
  double area_tolerance = 2;         // greatest factor between an area and its expected value
  int maximum_blobs = 64;            // so many of the largest blobs of a colour are looked at

  /// As the manual has it: the line from blue to red lies across the heading, red on the robot's
  /// right; the centre lies `offset` px ahead of its midpoint.
  static MarkerLayout across(double distance, double offset);

  /// From marker polygons in the robot's frame.
  static MarkerLayout from_markers(const Polygon& red, const Polygon& blue);

  double distance() const;  // between the two markers
  double offset() const;    // from the midpoint of the markers forward to the centre
};

/// Throws std::invalid_argument for values that are not finite, markers in one place and
/// tolerances that nothing fits.
void check_marker_layout(const MarkerLayout& markers);

/// The pose of the robot whose markers are among the blobs: the red-blue pair whose distance and
/// areas fit. Nothing, if no pair fits, or two fit as well. A blob at the border of the frame may
/// be cut off, so that its centroid says nothing: it is not used. Without known areas those of
/// the pair must be alike.
std::optional<Measurement> locate(const BlobsByColor& blobs, const MarkerLayout& markers,
                                  const PlaneMap& plane_map);

}  // namespace robsim
