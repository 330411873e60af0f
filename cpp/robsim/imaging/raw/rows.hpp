#pragma once

#include <cstdint>
#include <vector>

#include "robsim/imaging/raw/pixel_format.hpp"

namespace robsim::raw {

/// Turns a row of grey pixels into RGB8. Reads and writes nothing beyond the row.
void mono8_row(const std::uint8_t* raw, int width, std::uint8_t* rgb);

/// Of the high byte first, the lowest `bits` of the two in use.
void mono16_row(const std::uint8_t* raw, int width, int bits, std::uint8_t* rgb);

/// Turns a row of pixels into RGB8. Reads and writes nothing beyond the row.
void yuv411_row(const std::uint8_t* raw, int width, std::uint8_t* rgb);
void yuv422_row(const std::uint8_t* raw, int width, std::uint8_t* rgb);
void yuv444_row(const std::uint8_t* raw, int width, std::uint8_t* rgb);

/// Turns the rows of a Bayer frame into RGB8, from the first one downwards. Reads nothing beyond
/// the rows.
class BayerRows {
 public:
  /// The frame must be of 2 x 2 px at least, and not change until the last row is done.
  explicit BayerRows(const RawView& raw);

  void next_row(std::uint8_t* rgb);

 private:
  std::uint8_t* padded(int v);
  void read(int v);

  RawView raw_;
  std::size_t room_;                // bytes of a padded row
  std::vector<std::uint8_t> rows_;  // three, each with its mirrored neighbours at both ends
  int v_ = 0;
};

}  // namespace robsim::raw
