#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "robsim/vision/pixels/bit_row.hpp"

namespace robsim::pixels {

/// The inner loops of a sliding mean over a square window, for one CPU path.
struct WindowSums {
  using Sum = std::uint16_t;

  /// lower <= sum of the window in a channel <= upper
  struct Limits {
    std::size_t channel;
    Sum lower;
    Sum upper;
  };

  /// Per channel the column sums of the window, starting at the left end of the first window.
  using Columns = std::array<const Sum*, 3>;

  /// columns[i] += in[i] - out[i]: the window moves down by a row.
  void (*exchange)(const std::uint8_t* in, const std::uint8_t* out, std::size_t count,
                   Sum* columns);

  /// Sets the bits of the words first <= i < last, per class: whether the sum over the window
  /// around the pixel lies within all limits of the class.
  void (*classify)(const Columns& columns, std::size_t first, std::size_t last,
                   const std::vector<std::vector<Limits>>& classes, std::vector<BitRow>& bits);
};

/// The loops for a window of 3, 5, ... 15 px on the CPU path in use.
WindowSums window_sums(int window);

}  // namespace robsim::pixels
