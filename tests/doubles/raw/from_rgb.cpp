#include "raw/from_rgb.hpp"

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <map>
#include <string>

namespace robsim {

namespace {

// Y = 0.299 R + 0.587 G + 0.114 B
// U = 128 + (B - Y)/1.772
// V = 128 + (R - Y)/1.402
// Source: ITU-R BT.601; JFIF 1.02. In units of 1/65536.
constexpr int scale_bits = 16;

std::uint8_t luma_of(const std::uint8_t* rgb) {
  const int y = 19595 * rgb[0] + 38470 * rgb[1] + 7471 * rgb[2];
  return static_cast<std::uint8_t>((y + (1 << (scale_bits - 1))) >> scale_bits);
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
  for (int u = 0; u < width; ++u) raw[u] = luma_of(rgb + 3 * u);
}

void write_mono16(const std::uint8_t* rgb, int width, std::uint8_t* raw) {
  for (int u = 0; u < width; ++u, raw += 2) {
    raw[0] = raw[1] = luma_of(rgb + 3 * u);  // 257 Y
  }
}

// `order` names the bytes of a unit.
template <int count>
void write_yuv(const std::uint8_t* rgb, int width, std::uint8_t* raw, const char* order) {
  for (int first = 0; first < width; first += count) {
    const Chroma chroma = chroma_of<count>(rgb);
    for (const char* letter = order; *letter; ++letter) {
      *raw++ = *letter == 'U' ? chroma.u : *letter == 'V' ? chroma.v : luma_of(rgb);
      if (*letter == 'Y') rgb += 3;
    }
  }
}

void write_bayer(const ImageView& rgb, const std::string& filter, std::uint8_t* raw) {
  for (int v = 0; v < rgb.height; ++v) {
    for (int u = 0; u < rgb.width; ++u) {
      const char color = filter.at(static_cast<std::size_t>(2 * (v % 2) + u % 2));
      *raw++ = rgb.row(v)[3 * u + (color == 'r' ? 0 : color == 'g' ? 1 : 2)];
    }
  }
}

template <typename Write>
void write_rows(const ImageView& rgb, const PixelFormat& format, std::uint8_t* raw, Write&& write) {
  const std::size_t bytes = bytes_of_row(format, rgb.width);
  for (int v = 0; v < rgb.height; ++v, raw += bytes) write(rgb.row(v), rgb.width, raw);
}

}  // namespace

void from_rgb(const ImageView& rgb, const PixelFormat& format, std::uint8_t* raw) {
  check_size(format, rgb.width, rgb.height);
  const auto rows = [&](auto write) { write_rows(rgb, format, raw, write); };
  const auto yuv = [&](auto write, const char* order) {
    rows([&](const auto* from, int width, auto* to) { write(from, width, to, order); });
  };
  const auto rgb8 = [](int first) {  // the first channel: 0 or 2
    return [first](const std::uint8_t* from, int width, std::uint8_t* to) {
      for (int u = 0; u < width; ++u, from += 3) {
        for (int i = 0; i < 3; ++i) *to++ = from[std::abs(first - i)];
      }
    };
  };
  const std::map<std::string, std::function<void()>> writers{
      {"mono8", [&] { rows(write_mono8); }},
      {"mono16", [&] { rows(write_mono16); }},
      {"yuv411", [&] { yuv(write_yuv<4>, "UYYVYY"); }},
      {"yuv422", [&] { yuv(write_yuv<2>, "UYVY"); }},
      {"yuyv", [&] { yuv(write_yuv<2>, "YUYV"); }},
      {"yuv444", [&] { yuv(write_yuv<1>, "UYV"); }},
      {"rgb8", [&] { rows(rgb8(0)); }},
      {"bgr8", [&] { rows(rgb8(2)); }},
  };
  const auto found = writers.find(format.name);
  found == writers.end() ? write_bayer(rgb, std::string(format.name).substr(6), raw)
                         : found->second();
}

}  // namespace robsim
