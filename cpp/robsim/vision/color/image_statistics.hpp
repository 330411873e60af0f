#pragma once

#include <array>

#include "robsim/imaging/image.hpp"

namespace robsim {

/// U and V of what most of an image shows, which is the floor around the markers.
struct SurroundingChroma {
  std::array<double, 2> median;  // levels
  std::array<double, 2> spread;  // standard deviation of the mean of 7 x 7 pixels (levels)
};

/// Of the image in blocks of 7 x 7 pixels, which is the window that finds markers in noise: median
/// of their means, and half of what lies between their 16th and 84th percentile, so that the
/// markers themselves hardly count.
SurroundingChroma surrounding_chroma(const ImageView& image);

/// Standard deviation of the noise of a pixel's R, G or B (grey levels), by the median second
/// difference of neighbouring pixels on a grid over the image: slopes, edges and blobs hardly
/// change it. Compression, which smooths, hides noise.
/// Method: Immerkaer 1996, Fast noise variance estimation; with a median in place of the mean.
double grey_noise(const ImageView& image);

}  // namespace robsim

namespace robsim::pixels {

/// Standard deviation of the noise of a pixel's U or V, whichever is larger (levels), by the median
/// difference of neighbouring pixels on a grid over the image: edges and blobs hardly change it.
double chroma_noise(const ImageView& image);

}  // namespace robsim::pixels
