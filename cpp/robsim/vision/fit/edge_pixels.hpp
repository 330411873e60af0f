#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "robsim/imaging/image.hpp"
#include "robsim/imaging/plane_map.hpp"
#include "robsim/vision/fit/marker_shape.hpp"

namespace robsim::fit {

/// Pixels around the edge of a marker, as seen from a pose of the robot.
struct EdgeBlock {
  static constexpr int size = 32;

  alignas(32) float distance[size];  // from the edge, above 0 inside; work-area px
  // Its derivatives by x and y in the robot's frame, and by the heading (work-area px/rad):
  alignas(32) float normal_x[size];
  alignas(32) float normal_y[size];
  alignas(32) float turn[size];
  alignas(32) float color[3][size];  // R, G, B, from `grey`
  alignas(32) float weight[size];    // square root; 0 = no pixel
  alignas(32) float coverage[size];  // T, and its slope: see edge_model.hpp
  alignas(32) float slope[size];
  std::int32_t place[size];  // row by row in the box, see `EdgePixels`
};

struct EdgePixels {
  static constexpr float grey = 128;  // in the middle of all levels: what is left is small

  static constexpr int gap = 2;  // no pixel has one of another row beside it, or next but one

  EdgePixels() { blocks.reserve(24); }

  /// The block in which the next pixel is, and its place there; it is all zero.
  std::pair<EdgeBlock*, int> next();
  /// Adds a pixel of other pixels in the same box.
  void add(const EdgeBlock& block, int k);

  std::vector<EdgeBlock> blocks;
  int count = 0;
  int left = 0, top = 0;  // of the box around them, in the picture (px)
  int stride = 0;         // of its rows (px), `gap` columns of it free
  int height = 0;         // px
  double scale = 0;       // frame px per work-area px
};

/// How far the ring of pixels reaches (frame px).
struct Ring {
  double outside = 2.5;
  double inside = 4;
};

/// Gathers the pixels of an image at the edge of a marker of a robot at `pose`. None if the marker
/// is not in the image, or `map` does not show it, or its edge takes more than some 262 000 px.
void gather(const ImageView& image, const PlaneMap& map, const MarkerShape& shape, const Pose& pose,
            const Ring& ring, EdgePixels& pixels);

}  // namespace robsim::fit
