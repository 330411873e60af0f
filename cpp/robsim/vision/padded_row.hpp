#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "robsim/vision/bit_row.hpp"

namespace robsim {

/// A row of RGB8 in 64 pixels at a time, the last of them filled up with black ones, so that one
/// may read a byte beyond each 64.
class PaddedRow {
 public:
  PaddedRow(const std::uint8_t* rgb, int width) : last_(words_of(width) - 1) {
    const std::size_t left = 3 * (static_cast<std::size_t>(width) - 64 * last_);
    std::memcpy(padded_, rgb + 192 * last_, left);
    std::memset(padded_ + left, 0, sizeof padded_ - left);
  }

  const std::uint8_t* pixels(const std::uint8_t* rgb, std::size_t word) const {
    return word < last_ ? rgb + 192 * word : padded_;
  }

 private:
  std::size_t last_;
  std::uint8_t padded_[193];
};

}  // namespace robsim
