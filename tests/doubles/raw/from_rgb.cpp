#include "raw/from_rgb.hpp"

#include <algorithm>
#include <cstring>

namespace robsim {

namespace {

// Y = 0.299 R + 0.587 G + 0.114 B
// U = 128 + (B - Y)/1.772
// V = 128 + (R - Y)/1.402
// Source: ITU-R BT.601; JFIF 1.02. In units of 1/65536.
constexpr int scale_bits = 16;

int luma_of(const std::uint8_t* rgb) {
  const int y = 19595 * rgb[0] + 38470 * rgb[1] + 7471 * rgb[2];
  return (y + (1 << (scale_bits - 1))) >> scale_bits;
}

struct Chroma {
  std::uint8_t u;
  std::uint8_t v;
};

// The mean of `count` pixels, 1, 2 or 4.
template <int count>
Chroma chroma_of(const std::uint8_t* rgb) {
  int r = 0;
  int g = 0;
  int b = 0;
  for (int i = 0; i < count; ++i) {
    r += rgb[3 * i];
    g += rgb[3 * i + 1];
    b += rgb[3 * i + 2];
  }
  const auto level = [](int sum) {
    constexpr int unit = count << scale_bits;
    return static_cast<std::uint8_t>(std::clamp((sum + 128 * unit + unit / 2) / unit, 0, 255));
  };
  return {level(-11059 * r - 21709 * g + 32768 * b), level(32768 * r - 27439 * g - 5329 * b)};
}

void write_mono8(const std::uint8_t* rgb, int width, std::uint8_t* raw) {
  for (int u = 0; u < width; ++u) raw[u] = static_cast<std::uint8_t>(luma_of(rgb + 3 * u));
}

void write_mono16(const std::uint8_t* rgb, int width, std::uint8_t* raw) {
  for (int u = 0; u < width; ++u, raw += 2) {
    raw[0] = raw[1] = static_cast<std::uint8_t>(luma_of(rgb + 3 * u));  // 257 Y
  }
}

// U and V each stand before half of the unit's Y; a single one comes between them.
template <int count>
void write_yuv(const std::uint8_t* rgb, int width, std::uint8_t* raw) {
  constexpr int before_v = (count + 1) / 2;
  for (int first = 0; first < width; first += count) {
    const Chroma chroma = chroma_of<count>(rgb);
    for (int i = 0; i < count; ++i, rgb += 3) {
      if (i == 0) *raw++ = chroma.u;
      if (i == before_v) *raw++ = chroma.v;
      *raw++ = static_cast<std::uint8_t>(luma_of(rgb));
    }
    if (before_v == count) *raw++ = chroma.v;
  }
}

void write_bayer(const ImageView& rgb, PixelFormat format, std::uint8_t* raw) {
  const bool is_red_up = format == PixelFormat::bayer_rggb || format == PixelFormat::bayer_grbg;
  const bool is_green_first =
      format == PixelFormat::bayer_grbg || format == PixelFormat::bayer_gbrg;
  for (int v = 0; v < rgb.height; ++v) {
    const int channel = (v % 2 == 0) == is_red_up ? 0 : 2;
    const int green = (v % 2 == 0) == is_green_first ? 0 : 1;
    const std::uint8_t* row = rgb.row(v);
    for (int u = 0; u < rgb.width; ++u) *raw++ = row[3 * u + (u % 2 == green ? 1 : channel)];
  }
}

template <typename Write>
void write_rows(const ImageView& rgb, PixelFormat format, std::uint8_t* raw, Write&& write) {
  const std::size_t bytes = bytes_of_row(format, rgb.width);
  for (int v = 0; v < rgb.height; ++v, raw += bytes) write(rgb.row(v), rgb.width, raw);
}

}  // namespace

void from_rgb(const ImageView& rgb, PixelFormat format, std::uint8_t* raw) {
  check_size(format, rgb.width, rgb.height);
  const auto rows = [&](auto write) { write_rows(rgb, format, raw, write); };
  switch (format) {
    case PixelFormat::mono8:
      return rows(write_mono8);
    case PixelFormat::mono16:
      return rows(write_mono16);
    case PixelFormat::yuv411:
      return rows(write_yuv<4>);
    case PixelFormat::yuv422:
      return rows(write_yuv<2>);
    case PixelFormat::yuv444:
      return rows(write_yuv<1>);
    case PixelFormat::rgb8:
      return rows([](const std::uint8_t* from, int width, std::uint8_t* to) {
        std::memcpy(to, from, std::size_t{3} * static_cast<std::size_t>(width));
      });
    default:
      write_bayer(rgb, format, raw);
  }
}

}  // namespace robsim
