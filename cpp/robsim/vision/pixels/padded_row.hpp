#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "robsim/vision/pixels/bit_row.hpp"

namespace robsim {

/// A row of RGB8 in 64 pixels at a time, the last of them filled up with black ones, so that one
/// may read a byte beyond each 64.
class PaddedRow {
 public:
  PaddedRow(const std::uint8_t* rgb, int width)
      : rgb_(rgb),
        last_(words_of(width) - 1),
        left_(3 * (static_cast<std::size_t>(width) - 64 * last_)) {}

  /// The last ones are copied when they are asked for: the pixels before them are in the cache by
  /// then, or on the way to it.
  const std::uint8_t* pixels(std::size_t word) {
    if (word < last_) return rgb_ + 192 * word;
    std::memcpy(padded_, rgb_ + 192 * last_, left_);
    std::memset(padded_ + left_, 0, sizeof padded_ - left_);
    return padded_;
  }

 private:
  const std::uint8_t* rgb_;
  std::size_t last_;
  std::size_t left_;  // bytes of the last ones
  std::uint8_t padded_[193];
};

}  // namespace robsim
