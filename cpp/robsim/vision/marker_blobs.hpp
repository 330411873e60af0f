#pragma once

#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/find_blobs.hpp"
#include "robsim/vision/locate.hpp"

namespace robsim {

/// The options of find_blobs that find the markers of a robot, in noise, too, in a width x height
/// frame of this plane map: a smoothing window of 0.28 of the width of the smaller marker, at most
/// 7 px; a minimum area of 1/8 of the smaller marker; the maximum number of blobs of the layout.
/// Without known areas: the default options.
BlobOptions marker_blobs(const MarkerLayout& markers, const PlaneMap& plane_map, int width,
                         int height);

}  // namespace robsim
