#pragma once

#include <cstddef>
#include <cstdint>

namespace robsim::pixels {

/// Writes Y, U and V of the pixels first <= u < last of a row of RGB8 to planes[0], [1] and [2],
/// each a row of its own; null skips a channel. `first` is a multiple of 64. What follows the last
/// pixel may be overwritten, too, up to the next multiple of 64.
void convert_to_planes(const std::uint8_t* rgb, int first, int last, std::uint8_t* const* planes);

/// The inner loops of a sliding mean over a square window, for one CPU path.
struct WindowSums {
  using Sum = std::uint16_t;

  /// lower <= sum of the window in a channel <= upper
  struct Limits {
    std::size_t channel;
    Sum lower;
    Sum upper;
  };

  /// How far `sum` may read beyond the columns that the windows need.
  static constexpr std::size_t read_ahead = 64;

  /// columns[i] += in[i] - out[i]: the window moves down by a row.
  void (*exchange)(const std::uint8_t* in, const std::uint8_t* out, std::size_t count,
                   Sum* columns);

  /// sums[i] = columns[i] + columns[i + 1] + ... over the width of the window, for 64 i per word.
  void (*sum)(const Sum* columns, std::size_t words, Sum* sums);

  /// Clears bit i of the words unless sums[i] lies within the limits.
  void (*limit)(const Sum* sums, const Limits& limits, std::size_t words, std::uint64_t* bits);
};

/// The loops for a window of 3, 5, ... 15 px on the CPU path in use; of 1 px `exchange` alone.
WindowSums window_sums(int window);

}  // namespace robsim::pixels
