#pragma once

#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/find_blobs.hpp"
#include "robsim/vision/locate.hpp"

namespace robsim {

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
