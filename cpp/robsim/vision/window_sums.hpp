#pragma once

#include <cstddef>
#include <cstdint>

namespace robsim {

/// The loops of a sliding mean over a square window, for one of the paths of the processor.
struct WindowSums {
  using Sum = std::uint16_t;

  /// columns[i] += in[i] - out[i]: the window moves down by a row.
  void (*exchange)(const std::uint8_t* in, const std::uint8_t* out, std::size_t count,
                   Sum* columns);

  /// sums[i] = columns[i] + ... + columns[i + window - 1]
  void (*add_up)(const Sum* columns, std::size_t count, Sum* sums);

  /// Bit i = lower <= sums[i] <= upper, for 64 of them.
  std::uint64_t (*within)(const Sum* sums, Sum lower, Sum upper);
};

/// Those for a window of 3, 5, ... 15 px, on the path in use.
WindowSums window_sums(int window);

}  // namespace robsim
