#pragma once

#include <optional>

#include "robsim/base/geometry.hpp"
#include "robsim/imaging/image.hpp"

namespace robsim {

/// The place of a marker of unknown outline.
struct WeightedCentroid {
  Point centroid;       // px of the frame
  double variance = 0;  // of either coordinate (px^2)
};

/// The centroid of the pixels in and around a blob, weighted by how much of the marker's colour
/// they have, between 20 % and 80 % of it: pixels that the edge of the marker crosses count in
/// part. Nothing if the blob has no colour of its own.
std::optional<WeightedCentroid> weighted_centroid(const ImageView& image, const PixelBox& blob,
                                                  const Point& middle);

}  // namespace robsim
