#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

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
