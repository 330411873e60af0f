#pragma once

#include <cstdint>
#include <vector>

#include "robsim/imaging/raw/pixel_format.hpp"

namespace robsim::raw {

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
