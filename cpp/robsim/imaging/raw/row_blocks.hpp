#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "robsim/base/simd/target.hpp"

namespace robsim::raw {

/// Pixels that one step of a loop in vectors converts.
constexpr int pixels_of_block = 32;

/// Calls convert(raw, rgb) for blocks of 32 pixels of a row, whose raw bytes are `bits` for each
/// pixel. It may read up to 6 bytes beyond the block: the last block is a copy with room.
template <int bits, typename Convert>
ROBSIM_INLINE void for_each_block(const std::uint8_t* raw, int width, std::uint8_t* rgb,
                                  Convert&& convert) {
  constexpr std::size_t bytes = pixels_of_block * bits / 8;
  int left = width;
  for (; left > pixels_of_block; left -= pixels_of_block) {
    convert(raw, rgb);
    raw += bytes;
    rgb += 3 * pixels_of_block;
  }
  std::uint8_t padded[bytes + 6] = {};
  std::uint8_t result[3 * pixels_of_block];
  std::memcpy(padded, raw, static_cast<std::size_t>(left * bits / 8));
  convert(padded, result);
  std::memcpy(rgb, result, std::size_t{3} * static_cast<std::size_t>(left));
}

}  // namespace robsim::raw
