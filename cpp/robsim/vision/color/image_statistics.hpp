#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "robsim/imaging/image.hpp"

namespace robsim {

/// The middle one of some numbers, of two the larger; reorders them.
template <typename Numbers>
auto median_of(Numbers& numbers) {
  const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return *middle;
}

/// Calls look(u, v) for the places of a grid over a box of pixels, row by row.
template <typename Look>
void look_at_grid(const PixelBox& box, int rows, int columns, Look look) {
  for (int i = 0; i < rows; ++i) {
    const int v = box.top + i * (box.bottom - 1 - box.top) / (rows - 1);
    for (int j = 0; j < columns; ++j) {
      look(box.left + j * (box.right - 1 - box.left) / (columns - 1), v);
    }
  }
}

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
