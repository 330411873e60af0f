#pragma once

#include "robsim/imaging/image.hpp"

namespace robsim::pixels {

/// Standard deviation of the noise of a pixel's U or V, whichever is larger (levels), by the median
/// difference of neighbouring pixels on a grid over the image: edges and blobs hardly change it.
double chroma_noise(const ImageView& image);

}  // namespace robsim::pixels
