#include "robsim/vision/refine.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/vision/fit/weighted_centroid.hpp"
#include "robsim/vision/marker_signal.hpp"

namespace robsim {

namespace {

// A fit whose markers end further from the blobs than this (frame px) has left them.
constexpr double farthest_from_blobs = 3;

double frame_scale(const Pose& pose, const PlaneMap& map) {
  return 1 / std::sqrt(map.area_scale(map.to_pixel({pose.x, pose.y})));
}

// By error propagation from the two centroids, whose variances (work-area px^2) are independent:
// heading = direction from second to first, place = their middle - R(heading) that of the layout.
PoseCovariance covariance_of(const MarkerPair& pair, const double (&variances)[2],
                             const MarkerLayout& markers, const PlaneMap& map, double heading) {
  const Point first = map.to_world(pair.first.centroid);
  const Point second = map.to_world(pair.second.centroid);
  const Point apart{first.x - second.x, first.y - second.y};
  const double squared = apart.x * apart.x + apart.y * apart.y;
  const double x = (markers.first.position.x + markers.second.position.x) / 2;
  const double y = (markers.first.position.y + markers.second.position.y) / 2;
  const auto [sin, cos] = elementary::sin_cos(heading);
  PoseCovariance covariance = PoseCovariance::Zero();
  for (int k = 0; k < 2; ++k) {
    const double sign = k == 0 ? 1 : -1;
    Eigen::Matrix<double, 3, 2> j;
    j.row(2) << -sign * apart.y / squared, sign * apart.x / squared;
    j.row(0) = (x * sin + y * cos) * j.row(2);
    j.row(1) = (-x * cos + y * sin) * j.row(2);
    j(0, 0) += 0.5;
    j(1, 1) += 0.5;
    covariance += variances[k] * (j * j.transpose());
  }
  return covariance;
}

// The pose by weighted centroids, where both blobs have a colour of their own.
void weigh(Measurement& measurement, const MarkerLayout& markers, const ImageView& image,
           const PlaneMap& map) {
  MarkerPair pair = *measurement.pair;
  double variances[2];
  Blob* const blobs[2] = {&pair.first, &pair.second};
  for (int k = 0; k < 2; ++k) {
    const auto found = weighted_centroid(image, blobs[k]->box, blobs[k]->centroid);
    if (!found) return;
    blobs[k]->centroid = found->centroid;
    variances[k] = found->variance * map.area_scale(found->centroid);
  }
  const Pose pose = pose_of(pair, markers, map);
  const PoseCovariance covariance = covariance_of(pair, variances, markers, map, pose.heading);
  if (!is_finite(pose) || !covariance.allFinite()) return;
  measurement.pose = pose;
  measurement.covariance = covariance;
}

bool is_good(const PoseFit& fit) { return fit.has_converged && fit.moved <= farthest_from_blobs; }

// A robot that is drawn at so many headings, and in whole pixels, is elsewhere than its picture by
// up to half of such a step: variance step^2/12.
void add_drawing(Measurement& measurement, const PlaneMap& map, int headings) {
  if (headings == 0 || !measurement.covariance) return;
  const double pixel = 1 / frame_scale(measurement.pose, map);
  const double turn = 2 * pi / headings;
  PoseCovariance& covariance = *measurement.covariance;
  covariance(0, 0) += pixel * pixel / 12;
  covariance(1, 1) += pixel * pixel / 12;
  covariance(2, 2) += turn * turn / 12;
}

}  // namespace

void refine(Detection& detection, const ImageView& image, const PlaneMap& map, int headings) {
  if (!detection.measurement) return;
  Measurement& measurement = *detection.measurement;
  const MarkerLayout& markers = detection.markers;
  std::optional<PoseFit> fit;
  if (markers.first.shape && markers.second.shape) {
    const bool is_first = markers.is_first_farther_right();
    const Marker& one = is_first ? markers.first : markers.second;
    const Marker& other = is_first ? markers.second : markers.first;
    fit = fit_pose(image, map, *one.shape, *other.shape, measurement.pose);
  }
  if (fit) {
    measurement.misfit = fit->misfit;
    measurement.signal_to_noise = fit->signal_to_noise;
  }
  if (fit && is_good(*fit)) {
    measurement.pose = fit->pose;
    measurement.covariance = fit->covariance;
  } else {
    weigh(measurement, markers, image, map);
    // What the outlines do not explain, the centroids feel, too.
    if (fit && measurement.covariance) *measurement.covariance *= std::max(1.0, fit->misfit);
  }
  add_drawing(measurement, map, headings);
  if (measurement.signal_to_noise < least_signal_to_noise) {
    detection.result = DetectionResult::noise;
    detection.cause = measurement.signal_to_noise;
    detection.measurement.reset();
  }
}

}  // namespace robsim
