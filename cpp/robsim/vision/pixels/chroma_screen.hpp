#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "robsim/vision/color/color_class.hpp"

namespace robsim {

/// Passes over grey pixels quickly: tells, 64 pixels at a time, where no class can have a member,
/// since the channels of every pixel there differ by too little. Most of a floor is like that.
class ChromaScreen {
 public:
  explicit ChromaScreen(const std::vector<ColorClass>& classes);

  /// Sets may_hold[i] to 0 if none of the pixels 64 i .. 64 i + 63 of a row of RGB8 belongs to a
  /// class, nor any mean of such pixels, and to 1 otherwise.
  void look(const std::uint8_t* rgb, int width, std::vector<std::uint8_t>& may_hold) const;

 private:
  int safe_difference_;  // |R - G| and |G - B| up to which no pixel belongs to a class; -1 = none
};

}  // namespace robsim
