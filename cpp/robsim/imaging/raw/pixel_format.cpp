#include "robsim/imaging/raw/pixel_format.hpp"

#include <stdexcept>
#include <string>

namespace robsim {

const PixelFormat& pixel_format_named(const std::string& name) {
  std::string names;
  for (const PixelFormat& format : pixel_formats()) {
    if (name == format.name) return format;
    names += (names.empty() ? "'" : ", '") + std::string(format.name) + "'";
  }
  throw std::invalid_argument("format must be one of " + names + ", got '" + name + "'");
}

void check_size(const PixelFormat& format, int width, int height) {
  const auto refuse = [&](const std::string& expected) {
    throw std::invalid_argument("a frame in " + std::string(format.name) + " must be " + expected +
                                ", got " + size_text(width, height));
  };
  const int least = *format.filter ? 2 : 1;
  if (width < least || height < least) {
    refuse(size_text(least, least) + " at least");
  }
  if (width % format.unit != 0) {
    refuse("a multiple of " + std::to_string(format.unit) + " px wide");
  }
}

std::size_t bytes_of_row(const PixelFormat& format, int width) {
  check_size(format, width, 2);
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(format.bits) / 8;
}

std::size_t bytes_of(const PixelFormat& format, int width, int height) {
  check_size(format, width, height);
  return bytes_of_row(format, width) * static_cast<std::size_t>(height);
}

RawView raw_view(const std::uint8_t* data, std::size_t bytes, const PixelFormat& format, int width,
                 int height) {
  const std::size_t needed = bytes_of(format, width, height);
  if (bytes < needed) {
    throw std::invalid_argument("a frame of " + size_text(width, height) + " in " + format.name +
                                " has " + std::to_string(needed) + " bytes, got " +
                                std::to_string(bytes));
  }
  const auto stride = static_cast<std::ptrdiff_t>(bytes_of_row(format, width));
  return {data, width, height, stride, format};
}

}  // namespace robsim
