#pragma once

#include "robsim/imaging/image.hpp"

namespace robsim {

/// Standard deviation of the noise of a pixel's R, G or B (grey levels), by the median second
/// difference of neighbouring pixels on a grid over the image: slopes, edges and blobs hardly
/// change it. Compression, which smooths, hides noise.
/// Method: Immerkaer 1996, Fast noise variance estimation; with a median in place of the mean.
double grey_noise(const ImageView& image);

}  // namespace robsim
