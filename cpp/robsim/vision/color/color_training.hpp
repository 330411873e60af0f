#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "robsim/imaging/image.hpp"
#include "robsim/vision/color/color_class.hpp"

namespace robsim {

/// How many pixels have each value of Y, U and V. Those of several images add up.
using ColorHistograms = std::array<std::array<std::int64_t, 256>, 3>;

/// Throws std::invalid_argument unless the region has pixels and lies within the image.
ColorHistograms color_histograms(const ImageView& image, const PixelBox& region);

struct TrainingOptions {
  double percentile = 33;  // % of the pixels; so many lie outside at each end of a channel's range
  int margin = 52;         // levels; what widens the ranges found
  bool limit_y = false;    // light and shadow change Y, so any Y is right
};

/// The colour class of a region with these histograms.
/// Shadow and noise take chroma towards neutral and never away from it: a range that lies to one
/// side of neutral is open at its far end. The range of the channel farthest from neutral stays
/// off the greys.
/// Throws std::invalid_argument for bad options, and where nothing but Y would tell the colour.
ColorClass color_from_histograms(const std::string& name, const ColorHistograms& histograms,
                                 const TrainingOptions& options = {});

/// The class with every end moved outwards by so many levels (negative: inwards) that is not open,
/// 0 or 255. Throws std::invalid_argument if nothing is left of a range.
ColorClass widened(const ColorClass& color, int margin);

}  // namespace robsim
