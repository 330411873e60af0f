#include "robsim/imaging/raw/pixel_format.hpp"

#include <stdexcept>
#include <string>
#include <utility>

namespace robsim {

namespace {

constexpr std::pair<PixelFormat, const char*> format_names[] = {
    {PixelFormat::mono8, "mono8"},           {PixelFormat::mono16, "mono16"},
    {PixelFormat::yuv411, "yuv411"},         {PixelFormat::yuv422, "yuv422"},
    {PixelFormat::yuv444, "yuv444"},         {PixelFormat::rgb8, "rgb8"},
    {PixelFormat::bayer_rggb, "bayer_rggb"}, {PixelFormat::bayer_grbg, "bayer_grbg"},
    {PixelFormat::bayer_gbrg, "bayer_gbrg"}, {PixelFormat::bayer_bggr, "bayer_bggr"},
};

int bits_of_pixel(PixelFormat format) {
  switch (format) {
    case PixelFormat::yuv411:
      return 12;
    case PixelFormat::mono16:
    case PixelFormat::yuv422:
      return 16;
    case PixelFormat::yuv444:
    case PixelFormat::rgb8:
      return 24;
    default:
      return 8;
  }
}

// Whole rows are of whole units of so many pixels.
int pixels_of_unit(PixelFormat format) {
  if (format == PixelFormat::yuv411) return 4;
  if (format == PixelFormat::yuv422) return 2;
  return 1;
}

}  // namespace

const char* name_of(PixelFormat format) {
  for (const auto& [named, name] : format_names) {
    if (named == format) return name;
  }
  throw std::invalid_argument("format is none of the pixel formats");
}

PixelFormat pixel_format_named(const std::string& name) {
  std::string names;
  for (const auto& [format, known] : format_names) {
    if (name == known) return format;
    names += (names.empty() ? "'" : ", '") + std::string(known) + "'";
  }
  throw std::invalid_argument("format must be one of " + names + ", got '" + name + "'");
}

bool is_bayer(PixelFormat format) {
  return format == PixelFormat::bayer_rggb || format == PixelFormat::bayer_grbg ||
         format == PixelFormat::bayer_gbrg || format == PixelFormat::bayer_bggr;
}

void check_size(PixelFormat format, int width, int height) {
  const auto refuse = [&](const std::string& expected) {
    throw std::invalid_argument("a frame in " + std::string(name_of(format)) + " must be " +
                                expected + ", got " + size_text(width, height));
  };
  const int least = is_bayer(format) ? 2 : 1;
  if (width < least || height < least) {
    refuse(size_text(least, least) + " at least");
  }
  const int unit = pixels_of_unit(format);
  if (width % unit != 0) refuse("a multiple of " + std::to_string(unit) + " px wide");
}

std::size_t bytes_of_row(PixelFormat format, int width) {
  check_size(format, width, 2);
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(bits_of_pixel(format)) / 8;
}

std::size_t bytes_of(PixelFormat format, int width, int height) {
  check_size(format, width, height);
  return bytes_of_row(format, width) * static_cast<std::size_t>(height);
}

RawView raw_view(const std::uint8_t* data, std::size_t bytes, PixelFormat format, int width,
                 int height) {
  const std::size_t needed = bytes_of(format, width, height);
  if (bytes < needed) {
    throw std::invalid_argument("a frame of " + size_text(width, height) + " in " +
                                name_of(format) + " has " + std::to_string(needed) +
                                " bytes, got " + std::to_string(bytes));
  }
  const auto stride = static_cast<std::ptrdiff_t>(bytes_of_row(format, width));
  return {data, width, height, stride, format};
}

}  // namespace robsim
