#pragma once

#include <Eigen/Core>
#include <optional>

#include "robsim/imaging/image.hpp"
#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/fit/marker_shape.hpp"

namespace robsim {

using PoseCovariance = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// A pose fitted to the edges of the markers.
struct PoseFit {
  Pose pose;
  PoseCovariance covariance;   // of x, y (work-area px) and heading (rad)
  double misfit = 1;           // factor on the variance, for what the fit leaves is no noise alone
  double remainder = 1;        // before edges are doubted.
  double signal_to_noise = 0;  // of the edges of both markers together
  bool has_converged = false;
  double moved = 0;  // frame px from the start: the marker that moved further
};

/// Adds to the covariance of a pose that it may be another, with the probability `share`. The
/// misfit grows as the variance that grows most.
void add_doubt(const Pose& pose, const Pose& other, double share, PoseCovariance& covariance,
               double& misfit);

/// Fits the pose of a robot to the edges of its two markers: weighted least squares over the RGB
/// pixels around the outlines, by Gauss and Newton. Level and contrast of each marker and channel
/// are free, and so are the blur and, within limits, the distance of the markers and their size: a
/// definition that is somewhat wrong does not pull at the pose. Where the light changes across a
/// marker, at the edge of a shadow or of what hides a part of it, the pixels on either side of that
/// line have levels and contrasts of their own. Where what is left is still not like noise, pixels
/// that do not fit count less. Nothing if an edge is not in the picture.
/// Error propagation: the inverse of the information of the pixels, times the misfit and a factor
/// for the second order in the noise. Where the residuals show that an edge may be hidden, the
/// poses of all such edges take part in the covariance, and the misfit grows.
std::optional<PoseFit> fit_pose(const ImageView& image, const PlaneMap& map,
                                const MarkerShape& first, const MarkerShape& second,
                                const Pose& start);

}  // namespace robsim
