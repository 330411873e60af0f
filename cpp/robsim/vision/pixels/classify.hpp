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
