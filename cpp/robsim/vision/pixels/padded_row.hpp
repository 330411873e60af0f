#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "robsim/vision/pixels/bit_row.hpp"

namespace robsim::pixels {

/// A row of RGB8 pixels in blocks of 64. The last block is padded with black, so that a byte beyond
/// any block may be read.
class PaddedRow {
 public:
  PaddedRow(const std::uint8_t* rgb, int width)
      : rgb_(rgb),
        last_(words_of(width) - 1),
        remainder_(3 * (static_cast<std::size_t>(width) - 64 * last_)) {}

  std::size_t blocks() const { return last_ + 1; }

  /// The last block is copied on demand only: by then the pixels before it are in the cache.
  const std::uint8_t* block(std::size_t word) {
    if (word < last_) return rgb_ + 192 * word;
    std::memcpy(padded_, rgb_ + 192 * last_, remainder_);
    std::memset(padded_ + remainder_, 0, sizeof padded_ - remainder_);
    return padded_;
  }

 private:
  const std::uint8_t* rgb_;
  std::size_t last_;
  std::size_t remainder_;  // bytes in the last block
  std::uint8_t padded_[193];
};

}  // namespace robsim::pixels
