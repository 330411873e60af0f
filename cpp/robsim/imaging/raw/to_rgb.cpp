#include "robsim/imaging/raw/to_rgb.hpp"

#include <stdexcept>
#include <string>

#include "robsim/imaging/raw/bayer_rows.hpp"
#include "robsim/imaging/raw/mono_rows.hpp"
#include "robsim/imaging/raw/yuv_rows.hpp"

namespace robsim {

namespace {

void check_views(const RawView& raw, const WritableView& rgb) {
  check_size(raw.format, raw.width, raw.height);
  if (rgb.width != raw.width || rgb.height != raw.height) {
    throw std::invalid_argument("rgb must have the size of the raw frame, " +
                                std::to_string(raw.width) + " x " + std::to_string(raw.height) +
                                " px, got " + std::to_string(rgb.width) + " x " +
                                std::to_string(rgb.height) + " px");
  }
  const auto row = static_cast<std::ptrdiff_t>(bytes_of_row(raw.format, raw.width));
  if (raw.stride < row || rgb.stride < std::ptrdiff_t{3} * rgb.width) {
    throw std::invalid_argument("stride must be at least the bytes of a row");
  }
  if (raw.bits < 8 || raw.bits > 16) {
    throw std::invalid_argument("bits must be 8 .. 16, got " + std::to_string(raw.bits));
  }
}

template <typename Convert>
void convert_rows(const RawView& raw, const WritableView& rgb, Convert&& convert) {
  for (int v = 0; v < raw.height; ++v) convert(raw.row(v), raw.width, rgb.row(v));
}

}  // namespace

void to_rgb(const RawView& raw, const WritableView& rgb) {
  check_views(raw, rgb);
  switch (raw.format) {
    case PixelFormat::mono8:
      return convert_rows(raw, rgb, raw::mono8_row);
    case PixelFormat::mono16:
      return convert_rows(raw, rgb, [&](const std::uint8_t* from, int width, std::uint8_t* to) {
        raw::mono16_row(from, width, raw.bits, to);
      });
    case PixelFormat::yuv411:
      return convert_rows(raw, rgb, raw::yuv411_row);
    case PixelFormat::yuv422:
      return convert_rows(raw, rgb, raw::yuv422_row);
    case PixelFormat::yuv444:
      return convert_rows(raw, rgb, raw::yuv444_row);
    case PixelFormat::rgb8:
      return copy({raw.data, raw.width, raw.height, raw.stride}, rgb);
    default:
      raw::BayerRows rows(raw);
      for (int v = 0; v < raw.height; ++v) rows.next_row(rgb.row(v));
  }
}

}  // namespace robsim
