#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace robsim {

/// Luma and chroma of one RGB8 pixel: full-range BT.601 with 7-bit coefficients, rounded down.
struct Yuv {
  int y;
  int u;
  int v;
};

inline Yuv rgb_to_yuv(const std::uint8_t* rgb) {
  const int r = rgb[0];
  const int g = rgb[1];
  const int b = rgb[2];
  return {(38 * r + 75 * g + 15 * b) >> 7, 128 + ((-22 * r - 42 * g + 64 * b) >> 7),
          128 + ((64 * r - 54 * g - 10 * b) >> 7)};
}

/// A named colour: a pixel belongs to it if its Y, U and V lie within the limits, both included.
struct ColorClass {
  std::string name;
  std::array<int, 3> lower = {0, 0, 0};
  std::array<int, 3> upper = {255, 255, 255};

  bool contains(const Yuv& yuv) const {
    return yuv.y >= lower[0] && yuv.y <= upper[0] && yuv.u >= lower[1] && yuv.u <= upper[1] &&
           yuv.v >= lower[2] && yuv.v <= upper[2];
  }
};

/// Throws std::invalid_argument unless it has a name and 0 <= lower <= upper <= 255.
void check_color_class(const ColorClass& color);

}  // namespace robsim
