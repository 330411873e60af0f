#pragma once

#include <array>

#include "robsim/imaging/image.hpp"

namespace robsim::light {

/// Factors on R, G and B.
using Gains = std::array<float, 3>;

/// The colour of most of an image, which is its floor: the median of each channel, on a grid.
std::array<int, 3> floor_color(const ImageView& image);

/// The gains with which a colour is grey, at most 4; 1 for one that is too dark to tell.
Gains gains_to_grey(const std::array<int, 3>& color);

}  // namespace robsim::light
