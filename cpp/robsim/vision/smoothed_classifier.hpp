#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "robsim/imaging/image.hpp"
#include "robsim/vision/bit_row.hpp"
#include "robsim/vision/color_class.hpp"

namespace robsim {

/// Tells which pixels belong to which class by the mean of the window of pixels around them, in
/// every channel that a class limits. Beyond the border of the image its outermost pixels go on.
class SmoothedClassifier {
 public:
  static constexpr int largest_window = 15;

  /// Throws std::invalid_argument unless the window is 3, 5, ... 15 px wide.
  SmoothedClassifier(const std::vector<ColorClass>& classes, int window);

  /// Begins with an image, which must stay as it is until its last row.
  void begin(const ImageView& image);

  /// Sets, for each class, the bits of the next row.
  void next_row(std::vector<BitRow>& bits);

 private:
  // lower <= sum of the window <= upper
  struct SumLimits {
    std::size_t channel;
    std::uint16_t lower;
    std::uint16_t upper;
  };

  struct Channel {
    bool is_needed = false;
    std::vector<std::uint8_t> rows;      // the newest ones, in turns
    std::vector<std::uint16_t> columns;  // sums of the window's rows, with a margin on both sides
    std::vector<std::uint16_t> sums;     // of the window
  };

  std::uint8_t* row(Channel& channel, int v);
  int within(int v) const;
  void convert(int v);
  void move_down();

  int window_;
  std::vector<std::vector<SumLimits>> limits_;  // per class
  Channel channels_[3];
  ImageView image_;
  std::size_t padded_width_ = 0;  // a multiple of 64
  int v_ = 0;
};

}  // namespace robsim
