#include "robsim/imaging/raw/mono_rows.hpp"

#include <algorithm>

namespace robsim::raw {

void mono8_row(const std::uint8_t* raw, int width, std::uint8_t* rgb) {
  for (int u = 0; u < width; ++u, rgb += 3) rgb[0] = rgb[1] = rgb[2] = raw[u];
}

void mono16_row(const std::uint8_t* raw, int width, int bits, std::uint8_t* rgb) {
  for (int u = 0; u < width; ++u, raw += 2, rgb += 3) {
    const int grey = ((raw[0] << 8) | raw[1]) >> (bits - 8);
    rgb[0] = rgb[1] = rgb[2] = static_cast<std::uint8_t>(std::min(grey, 255));
  }
}

}  // namespace robsim::raw
