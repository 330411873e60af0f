#pragma once

#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/find_blobs.hpp"
#include "robsim/vision/locate.hpp"

namespace robsim {

/// Signal-to-noise figure of the markers' edges from which a pose can be trusted, and below which
/// it is none: so much stands out of the noise anywhere.
constexpr double trusted_signal_to_noise = 4;
constexpr double least_signal_to_noise = 3;

/// The signal-to-noise figure to be expected of two round markers of this width (frame px: the side
/// of a square of the same area) in good light and a sharp picture, with noise of this standard
/// deviation in each channel (grey levels):
/// SNR^2 = sum over both of |contrast|^2 / noise^2 perimeter blur / 3.5.
/// Below 4.5 px, where a marker is all edge, it falls with the area, too.
double expected_signal_to_noise(double width, double noise);

/// The width of markers from which a pose can be trusted at this noise (frame px): that of the
/// figure 4, but no less than 2 px, below which they are hardly ever found.
double trusted_width(double noise);

/// Width of the smaller marker in the middle of a width x height frame (px): the side of a square
/// of its area. NaN if the areas are not known.
double marker_width(const MarkerLayout& markers, const PlaneMap& plane_map, int width, int height);

/// The options of find_blobs that find the markers of a robot, in noise, too, in an image of this
/// plane map: a smoothing window of 0.28 of the width of the smaller marker where it is smallest, 3
/// to 7 px, but none for markers below 7 px in an image without noise; a minimum area of 1/8 of
/// that marker; the maximum number of blobs of the layout. Without known areas: the defaults.
BlobOptions marker_blobs(const MarkerLayout& markers, const PlaneMap& plane_map,
                         const ImageView& image);

}  // namespace robsim
