#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "robsim/vision/pixels/bit_row.hpp"

namespace robsim {

/// The loops of a sliding mean over a square window, for one of the paths of the processor.
struct WindowSums {
  using Sum = std::uint16_t;

  /// lower <= sum of the window in a channel <= upper
  struct Limits {
    std::size_t channel;
    Sum lower;
    Sum upper;
  };

  /// Per channel the sums of the columns of the window, from the left end of the first window on.
  using Columns = std::array<const Sum*, 3>;

  /// columns[i] += in[i] - out[i]: the window moves down by a row.
  void (*exchange)(const std::uint8_t* in, const std::uint8_t* out, std::size_t count,
                   Sum* columns);

  /// Sets the bits of the words first <= i < last, per class: does the sum of the window around the
  /// pixel lie within all its limits?
  void (*classify)(const Columns& columns, std::size_t first, std::size_t last,
                   const std::vector<std::vector<Limits>>& classes, std::vector<BitRow>& bits);
};

/// Those for a window of 3, 5, ... 15 px, on the path in use.
WindowSums window_sums(int window);

}  // namespace robsim
