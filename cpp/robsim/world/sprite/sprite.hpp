#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace robsim {

/// A picture with transparency: 4 floats a pixel, R, G, B (0..255) times alpha, and 1 - alpha: how
/// much of the floor shows through.
struct Sprite {
  int width = 0;
  int height = 0;
  std::vector<float> pixels;

  const float* row(int v) const { return pixels.data() + std::ptrdiff_t{4} * width * v; }
  float* row(int v) { return pixels.data() + std::ptrdiff_t{4} * width * v; }
};

/// From RGBA8 pixels, colours not yet multiplied with alpha, without gaps between rows.
Sprite premultiplied(const std::uint8_t* rgba, int width, int height);

/// With a transparent rim: one pixel to the left and above, two to the right and below.
Sprite with_rim(const Sprite& sprite);

}  // namespace robsim
