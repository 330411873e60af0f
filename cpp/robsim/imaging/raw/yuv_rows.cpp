#include "robsim/imaging/raw/yuv_rows.hpp"

#include <algorithm>

namespace robsim::raw {

namespace {

// Where a unit of pixels has their Y, and the U and V that they share.
struct Unit411 {
  static constexpr int pixels = 4;
  static constexpr int bytes = 6;
  static constexpr int y[] = {1, 2, 4, 5};
  static constexpr int u = 0;
  static constexpr int v = 3;
};

struct Unit422 {
  static constexpr int pixels = 2;
  static constexpr int bytes = 4;
  static constexpr int y[] = {1, 3};
  static constexpr int u = 0;
  static constexpr int v = 2;
};

struct Unit444 {
  static constexpr int pixels = 1;
  static constexpr int bytes = 3;
  static constexpr int y[] = {1};
  static constexpr int u = 0;
  static constexpr int v = 2;
};

// R = Y + 1.402 (V - 128)
// G = Y - 0.344136 (U - 128) - 0.714136 (V - 128)
// B = Y + 1.772 (U - 128)
// Source: ITU-R BT.601; JFIF 1.02. Here in units of 1/64, factors in units of 1/16384: the
// products have room in 16 bits of a vector once they are rounded to 1/64.
constexpr int red_of_v = 22970;
constexpr int green_of_u = 5638;
constexpr int green_of_v = 11700;
constexpr int blue_of_u = 29032;

int chroma_term(int factor, int chroma) { return (factor * chroma + 128) >> 8; }

std::uint8_t level(int sixty_fourths) {
  return static_cast<std::uint8_t>(std::clamp((sixty_fourths + 32) >> 6, 0, 255));
}

template <typename Unit>
void convert_yuv_row(const std::uint8_t* raw, int width, std::uint8_t* rgb) {
  for (int first = 0; first < width; first += Unit::pixels, raw += Unit::bytes) {
    const int u = raw[Unit::u] - 128;
    const int v = raw[Unit::v] - 128;
    const int red = chroma_term(red_of_v, v);
    const int green = chroma_term(green_of_u, u) + chroma_term(green_of_v, v);
    const int blue = chroma_term(blue_of_u, u);
    for (const int at : Unit::y) {
      const int y = 64 * raw[at];
      rgb[0] = level(y + red);
      rgb[1] = level(y - green);
      rgb[2] = level(y + blue);
      rgb += 3;
    }
  }
}

}  // namespace

void yuv411_row(const std::uint8_t* raw, int width, std::uint8_t* rgb) {
  convert_yuv_row<Unit411>(raw, width, rgb);
}

void yuv422_row(const std::uint8_t* raw, int width, std::uint8_t* rgb) {
  convert_yuv_row<Unit422>(raw, width, rgb);
}

void yuv444_row(const std::uint8_t* raw, int width, std::uint8_t* rgb) {
  convert_yuv_row<Unit444>(raw, width, rgb);
}

}  // namespace robsim::raw
