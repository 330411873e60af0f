#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "robsim/base/geometry.hpp"

namespace robsim {

/// An image with transparency: 4 floats per pixel, R, G, B (0..255) times alpha, and 1 - alpha, the
/// weight of the background.
struct Sprite {
  int width = 0;
  int height = 0;
  std::vector<float> pixels;

  const float* row(int v) const { return pixels.data() + std::ptrdiff_t{4} * width * v; }
  float* row(int v) { return pixels.data() + std::ptrdiff_t{4} * width * v; }
};

/// From RGBA8 pixels with straight alpha, without gaps between rows.
Sprite premultiplied(const std::uint8_t* rgba, int width, int height);

/// With a transparent rim: one pixel to the left and above, two to the right and below.
Sprite with_rim(const Sprite& sprite);

}  // namespace robsim

namespace robsim::sprite {

/// A row of an image in sprite coordinates: the position of column 0, and the step per column.
struct SpriteLine {
  Point start;
  Point step;

  Point at(int u) const { return {start.x + u * step.x, start.y + u * step.y}; }
};

/// Columns first <= u < last of a row.
struct Span {
  int first = 0;
  int last = 0;
};

/// Those of the columns that lie within the sprite and before its last column and row, which
/// `sample` may read because of rounding.
Span span_within(const Sprite& sprite, const SpriteLine& line, const Span& columns);

/// Pixels to blend over a part of a row, from column `left` on. For each byte of the image: the
/// colour added to it, and the weight of the background.
struct Strip {
  int left = 0;
  int width = 0;
  std::vector<float> colors;
  std::vector<float> background_weight;
};

/// Samples the sprite bilinearly in columns that lie within it.
Strip sample(const Sprite& sprite, const SpriteLine& line, const Span& columns);

Strip without_transparent_ends(const Strip& strip);

/// Blends a part of the strip over pixels. `brightness`, within 0..1, is that of the strip.
void blend(const Strip& strip, const Span& part, float brightness, std::uint8_t* pixels);

/// Samples and blends in one pass.
void blend(const Sprite& sprite, const SpriteLine& line, const Span& columns, float brightness,
           std::uint8_t* pixels);

}  // namespace robsim::sprite
