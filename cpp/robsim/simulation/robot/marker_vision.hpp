#pragma once

#include <optional>
#include <vector>

#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/marker_width.hpp"

namespace robsim {

/// Finds a robot by its markers in frames of any size.
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

  /// Looks for the markers among the blobs of a frame.
  Detection detect(const BlobsByColor& blobs, const Frame& frame) const;

 private:
  MarkerLayout markers_;
  std::optional<int> smoothing_;
  BlobFinder finder_;
};

}  // namespace robsim
