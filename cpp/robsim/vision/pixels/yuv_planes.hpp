#pragma once

#include <cstdint>

namespace robsim {

/// Writes Y, U and V of the pixels first <= u < last of a row of RGB8 to planes[0], [1] and [2],
/// each a row of its own; null = that channel is not wanted. `first` is a multiple of 32; up to 31
/// numbers behind the last one may be written, too.
void convert_to_planes(const std::uint8_t* rgb, int first, int last, std::uint8_t* const* planes);

}  // namespace robsim
