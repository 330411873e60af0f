#pragma once

#include <cstdint>

namespace robsim::pixels {

/// Writes Y, U and V of the pixels first <= u < last of a row of RGB8 to planes[0], [1] and [2],
/// each a row of its own; null skips a channel. `first` is a multiple of 64. What follows the last
/// pixel may be overwritten, too, up to the next multiple of 64.
void convert_to_planes(const std::uint8_t* rgb, int first, int last, std::uint8_t* const* planes);

}  // namespace robsim::pixels
