#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "robsim/vision/color/color_class.hpp"
#include "robsim/vision/pixels/bit_row.hpp"

namespace robsim::pixels {

/// Skips grey pixels quickly: finds the blocks of 64 pixels that cannot contain a member of any
/// class, because the channels of each of their pixels differ by too little. Most of a floor is
/// grey.
class ChromaScreen {
 public:
  explicit ChromaScreen(const std::vector<ColorClass>& classes);

  /// Sets bit i unless neither any of the pixels 64 i .. 64 i + 63 of a row of RGB8 nor any mean
  /// of them belongs to a class.
  void screen(const std::uint8_t* rgb, int width, BitRow& may_contain) const;

 private:
  int safe_difference_;  // |R - G| and |G - B| up to which no pixel belongs to a class; -1 = none
};

}  // namespace robsim::pixels
