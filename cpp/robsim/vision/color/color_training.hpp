#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "robsim/imaging/image.hpp"
#include "robsim/vision/color/color_class.hpp"
#include "robsim/vision/color/surrounding_chroma.hpp"

namespace robsim {

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
