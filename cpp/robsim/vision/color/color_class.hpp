#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "robsim/imaging/image.hpp"
#include "robsim/vision/color/image_statistics.hpp"

namespace robsim {

/// Luma and chroma of one RGB8 pixel: full-range BT.601 with 7-bit coefficients, rounded down.
struct Yuv {
  int y;
  int u;
  int v;
};

inline Yuv rgb_to_yuv(const std::uint8_t* rgb) {
  const int r = rgb[0];
  const int g = rgb[1];
  const int b = rgb[2];
  return {(38 * r + 75 * g + 15 * b) >> 7, 128 + ((-22 * r - 42 * g + 64 * b) >> 7),
          128 + ((64 * r - 54 * g - 10 * b) >> 7)};
}

/// A named colour: a pixel belongs to it if its Y, U and V lie within the limits, both included.
struct ColorClass {
  std::string name;
  std::array<int, 3> lower = {0, 0, 0};
  std::array<int, 3> upper = {255, 255, 255};

  bool contains(const Yuv& yuv) const {
    return yuv.y >= lower[0] && yuv.y <= upper[0] && yuv.u >= lower[1] && yuv.u <= upper[1] &&
           yuv.v >= lower[2] && yuv.v <= upper[2];
  }
};

/// Throws std::invalid_argument unless it has a name and 0 <= lower <= upper <= 255.
void check_color_class(const ColorClass& color);

/// The number of pixels per value of Y, U and V. Histograms of several images add up.
using ColorHistograms = std::array<std::array<std::int64_t, 256>, 3>;

/// Throws std::invalid_argument unless the region is not empty and lies within the image.
ColorHistograms color_histograms(const ImageView& image, const PixelBox& region);

struct TrainingOptions {
  double percentile = 33;  // % of the pixels outside the range of a channel, at each end
  int margin = 52;         // levels by which the ranges found are widened
  bool limit_y = false;    // off: light and shadow change Y, so any Y belongs
};

/// The colour class of a region with these histograms.
/// Shadow and noise move chroma towards neutral, never away from it: a range on one side of neutral
/// is open at its far end. The range of the channel farthest from neutral stays away from grey.
/// With what lies around the region, it stays away from that, too, and a colour counts as one where
/// it stands out of the noise of both; otherwise, from 16 levels from neutral on, or a quarter of
/// its luma where that is less.
/// Throws std::invalid_argument for invalid options, and for grey regions unless Y is limited.
ColorClass color_from_histograms(const std::string& name, const ColorHistograms& histograms,
                                 const TrainingOptions& options = {},
                                 const std::optional<SurroundingChroma>& around = std::nullopt);

/// The class with every end moved outwards by `margin` levels (negative: inwards), except for open
/// ends at 0 and 255. Throws std::invalid_argument if a range becomes empty.
ColorClass widened(const ColorClass& color, int margin);

}  // namespace robsim
