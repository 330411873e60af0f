#pragma once

#include <cstdint>
#include <vector>

#include "robsim/geometry/pose.hpp"
#include "robsim/world/sprite/sprite.hpp"

namespace robsim {

/// Where a row of an image lies in a sprite: the place of column 0, and from one to the next.
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

/// The columns, out of some, that lie within the sprite and before its last column and row, which
/// `sample` may touch by rounding.
Span span_within(const Sprite& sprite, const SpriteLine& line, const Span& columns);

/// Pixels to be laid over a part of a row, from column `left` on. For each byte of the image: what
/// is added to it, and how much of it is kept.
struct Strip {
  int left = 0;
  int width = 0;
  std::vector<float> colors;
  std::vector<float> rest;
};

/// The sprite in columns that lie within it, bilinearly between its pixels.
Strip sample(const Sprite& sprite, const SpriteLine& line, const Span& columns);

Strip without_transparent_ends(const Strip& strip);

/// Lays a part of the strip over pixels. `brightness`, within 0..1, is that of the strip.
void blend(const Strip& strip, const Span& part, float brightness, std::uint8_t* pixels);

/// Samples and blends at once.
void blend(const Sprite& sprite, const SpriteLine& line, const Span& columns, float brightness,
           std::uint8_t* pixels);

}  // namespace robsim
