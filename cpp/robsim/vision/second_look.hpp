#pragma once

#include <optional>
#include <vector>

#include "robsim/base/geometry.hpp"
#include "robsim/imaging/image.hpp"
#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/color/color_class.hpp"
#include "robsim/vision/locate.hpp"

namespace robsim {

/// Makes the measurement of a detection, if there is one, as exact as the image allows, and says
/// how exact: fits the outlines of the markers to their edges; where they are unknown, or do not
/// fit, weighs the blobs' pixels by their colour. No measurement is left of what does not stand out
/// of the noise. `headings`: that the robot is drawn in, as of a Frame.
void refine(Detection& detection, const ImageView& image, const PlaneMap& plane_map, int headings);

/// A second chance for a detection without a pair: looks for its markers by colours relative to
/// brightness, as a saturation is, which neither dim light nor a gradient of light nor faded
/// markers hide; first relative to grey, then, under light that colours the floor, relative to the
/// floor. What is found takes the place of the detection; otherwise it stays as it is. Where the
/// first one found a pair, or so many blobs that one would be there by chance, there is no second
/// chance. `smoothing` (px), if not as markers and noise need it: in strong noise a window of up to
/// 0.4 of the marker's width, 9 px at most.
void look_again(Detection& detection, const ImageView& image, const std::vector<ColorClass>& colors,
                const PlaneMap& plane_map, std::optional<int> smoothing = std::nullopt);

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
