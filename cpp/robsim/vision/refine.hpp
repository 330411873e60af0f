#pragma once

#include "robsim/vision/locate.hpp"

namespace robsim {

/// Makes the measurement of a detection, if there is one, as exact as the image allows, and says
/// how exact: fits the outlines of the markers to their edges; where they are unknown, or do not
/// fit, weighs the blobs' pixels by their colour. No measurement is left of what does not stand out
/// of the noise. `headings`: that the robot is drawn in, as of a Frame.
void refine(Detection& detection, const ImageView& image, const PlaneMap& plane_map, int headings);

}  // namespace robsim
