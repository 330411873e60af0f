#pragma once

#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/find_blobs.hpp"
#include "robsim/vision/locate.hpp"

namespace robsim {

/// The options of find_blobs with which the markers of a robot are found, in noise, too, in a
/// width x height frame of this plane map: smoothing over 0.28 of the width of the smaller marker,
/// at most 7 px, at least an eighth of its area, the marker layout's number of blobs. Without known
/// areas: the default options.
BlobOptions marker_blobs(const MarkerLayout& markers, const PlaneMap& plane_map, int width,
                         int height);

}  // namespace robsim
