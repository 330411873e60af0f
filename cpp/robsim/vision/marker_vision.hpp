#pragma once

#include <optional>
#include <vector>

#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/color/color_class.hpp"
#include "robsim/vision/find_blobs.hpp"
#include "robsim/vision/locate.hpp"

namespace robsim {

/// Detects a robot in a frame: chooses the pair of these blobs that fits the markers best, and
/// refines its pose in the image.
///
/// Without a pair, the markers get a second chance by these colours relative to brightness, like a
/// saturation. Dim light, a gradient of light and faded markers do not hide them there. The colours
/// are relative to grey first, then, in light that colours the floor, to the floor. Without
/// colours, and with so many blobs that a pair would fit by chance, there is no second chance.
/// `smoothing` (px) replaces the window that follows from markers and noise. In strong noise it has
/// up to 0.4 of the marker's width, 9 px at most.
///
/// A measurement gets its covariance from a fit of the markers' outlines to their edges. If the
/// outlines are unknown, or do not fit, the blobs' pixels are weighed by their colour. A
/// measurement that does not stand out of the noise is dropped, and so is one whose blobs are not
/// like the outlines.
///
/// Without a measurement, the frame is searched for the cause: a dark or overexposed picture
/// instead of "no red blob", markers too small to be found.
Detection detect(const BlobsByColor& blobs, const MarkerLayout& markers, const Frame& frame,
                 const std::vector<ColorClass>& colors,
                 std::optional<int> smoothing = std::nullopt);

/// Colours and markers of a robot, and a finder of their blobs in frames of any size.
class MarkerVision {
 public:
  /// `smoothing` (px), if not as the markers need it.
  MarkerVision(std::vector<ColorClass> colors, const MarkerLayout& markers,
               std::optional<int> smoothing);

  const std::vector<ColorClass>& colors() const { return finder_.colors(); }
  const MarkerLayout& markers() const { return markers_; }
  std::optional<int> smoothing() const { return smoothing_; }

  /// How blobs were found in the last frame.
  const BlobOptions& options() const { return finder_.options(); }

  BlobsByColor find(const Frame& frame);

 private:
  MarkerLayout markers_;
  std::optional<int> smoothing_;
  BlobFinder finder_;
};

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
