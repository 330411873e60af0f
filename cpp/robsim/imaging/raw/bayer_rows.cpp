#include "robsim/imaging/raw/bayer_rows.hpp"

#include <cstddef>
#include <cstring>

namespace robsim::raw {

namespace {

constexpr std::size_t pixels_of_block = 32;

// In the rows of red pixels the other ones are green, in those of blue pixels, too.
bool has_red(PixelFormat format, int v) {
  const bool begins_with_red =
      format == PixelFormat::bayer_rggb || format == PixelFormat::bayer_grbg;
  return (v % 2 == 0) == begins_with_red;
}

bool begins_with_green(PixelFormat format, int v) {
  const bool first = format == PixelFormat::bayer_grbg || format == PixelFormat::bayer_gbrg;
  return (v % 2 == 0) == first;
}

int mean_of_2(int a, int b) { return (a + b + 1) >> 1; }
int mean_of_4(int a, int b, int c, int d) { return (a + b + c + d + 2) >> 2; }

// Channel `own`, 0 or 2, is that of the row's pixels that are not green, `other` that of the rows
// above and below.
void bayer_row(const std::uint8_t* above, const std::uint8_t* row, const std::uint8_t* below,
               int width, bool is_green_first, int own, std::uint8_t* rgb) {
  const int other = 2 - own;
  for (int u = 0; u < width; ++u, rgb += 3) {
    const auto set = [&](int channel, int value) {
      rgb[channel] = static_cast<std::uint8_t>(value);
    };
    if ((u % 2 == 0) == is_green_first) {
      set(own, mean_of_2(row[u - 1], row[u + 1]));
      set(1, row[u]);
      set(other, mean_of_2(above[u], below[u]));
    } else {
      set(own, row[u]);
      set(1, mean_of_4(row[u - 1], row[u + 1], above[u], below[u]));
      set(other, mean_of_4(above[u - 1], above[u + 1], below[u - 1], below[u + 1]));
    }
  }
}

}  // namespace

BayerRows::BayerRows(const RawView& raw)
    : raw_(raw),
      room_(static_cast<std::size_t>(raw.width) + 2 + pixels_of_block),
      rows_(3 * room_) {
  read(0);
  read(1);
}

std::uint8_t* BayerRows::padded(int v) {
  return rows_.data() + room_ * static_cast<std::size_t>(v % 3) + 1;
}

void BayerRows::read(int v) {
  std::uint8_t* row = padded(v);
  std::memcpy(row, raw_.row(v), static_cast<std::size_t>(raw_.width));
  row[-1] = row[1];  // of the same colour as the pixel that is not there
  row[raw_.width] = row[raw_.width - 2];
}

void BayerRows::next_row(std::uint8_t* rgb) {
  if (v_ > 0 && v_ + 1 < raw_.height) read(v_ + 1);
  const int above = v_ == 0 ? 1 : v_ - 1;
  const int below = v_ + 1 == raw_.height ? v_ - 1 : v_ + 1;
  bayer_row(padded(above), padded(v_), padded(below), raw_.width,
            begins_with_green(raw_.format, v_), has_red(raw_.format, v_) ? 0 : 2, rgb);
  ++v_;
}

}  // namespace robsim::raw
