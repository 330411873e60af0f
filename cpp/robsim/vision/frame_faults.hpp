#pragma once

#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/locate.hpp"

namespace robsim {

/// Looks in the frame for the cause of a detection without a measurement: a dark or overexposed
/// picture in place of "no red blob", markers too small to be found.
void examine_frame(Detection& detection, const ImageView& image, const PlaneMap& plane_map);

}  // namespace robsim
