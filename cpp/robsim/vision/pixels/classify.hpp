#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "robsim/vision/color/color_class.hpp"
#include "robsim/vision/pixels/bit_row.hpp"
#include "robsim/vision/pixels/chroma_screen.hpp"

namespace robsim::pixels {

/// The limits of a class in a channel (0 = Y, 1 = U, 2 = V) that it restricts.
struct ChannelLimits {
  std::size_t channel;
  std::uint8_t lower;
  std::uint8_t upper;
};

/// Decides which pixels belong to which class, each by its own colour.
class Classifier {
 public:
  static constexpr std::size_t maximum_classes = 32;

  /// Throws std::invalid_argument for more than `maximum_classes`.
  explicit Classifier(const std::vector<ColorClass>& classes);

  /// Sets, for each class, the bits of the pixels of a row of RGB8 that belong to it.
  void classify(const std::uint8_t* rgb, int width, std::vector<BitRow>& bits);

 private:
  std::vector<std::vector<ChannelLimits>> limits_;  // per class
  ChromaScreen screen_;
  BitRow may_contain_;  // a member, a bit per block of 64 pixels
};

}  // namespace robsim::pixels
