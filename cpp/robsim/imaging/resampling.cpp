#include "robsim/imaging/resampling.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace robsim {

namespace {

constexpr int largest_factor = 4;

// One row of means of blocks. Whole rows are added before single pixels are picked from them: that
// makes sums that nobody needs, but in vectors of the processor.
template <int factor>
void reduce_row(const ImageView& from, int top, std::uint16_t* __restrict sums,
                std::uint8_t* __restrict means, std::uint8_t* __restrict to, int width) {
  constexpr std::uint16_t area = factor * factor;
  const int bytes = 3 * factor * width;
  const std::uint8_t* first = from.row(top);
  for (int i = 0; i < bytes; ++i) sums[i] = first[i];
  for (int v = 1; v < factor; ++v) {
    const std::uint8_t* next = from.row(top + v);
    for (int i = 0; i < bytes; ++i) sums[i] = static_cast<std::uint16_t>(sums[i] + next[i]);
  }
  for (int i = 0; i < bytes - 3 * (factor - 1); ++i) {
    std::uint16_t total = static_cast<std::uint16_t>(sums[i] + area / 2);
    for (int u = 1; u < factor; ++u) total = static_cast<std::uint16_t>(total + sums[i + 3 * u]);
    means[i] = static_cast<std::uint8_t>(total / area);
  }
  for (int u = 0; u < width - 1; ++u) std::memcpy(to + 3 * u, means + 3 * factor * u, 4);
  std::memcpy(to + 3 * (width - 1), means + 3 * factor * (width - 1), 3);
}

template <int factor>
Image reduced_by(const ImageView& from) {
  Image result(from.width / factor, from.height / factor);
  const WritableView to = result.writable_view();
  std::vector<std::uint16_t> sums(3 * static_cast<std::size_t>(from.width));
  std::vector<std::uint8_t> means(sums.size());
  for (int v = 0; v < to.height; ++v) {
    reduce_row<factor>(from, factor * v, sums.data(), means.data(), to.row(v), to.width);
  }
  return result;
}

Image reduced_by(const ImageView& from, int factor) {
  if (factor == 2) return reduced_by<2>(from);
  if (factor == 3) return reduced_by<3>(from);
  return reduced_by<largest_factor>(from);
}

}  // namespace

Image reduced(const Image& image, int width) {
  Image result = image;
  while (result.width() >= 2 * width && result.height() >= largest_factor) {
    const int factor = std::min(result.width() / width, largest_factor);
    result = reduced_by(result.view(), factor);
  }
  return result;
}

namespace {

constexpr std::uint16_t outside = 0xffff;
constexpr std::uint8_t grey = 128;

// Two neighbouring pixels as six bytes of a number, the left one in its lower ones.
std::uint64_t two_pixels(const std::uint8_t* p) {
  const auto low = std::uint32_t{p[0]} | std::uint32_t{p[1]} << 8 | std::uint32_t{p[2]} << 16 |
                   std::uint32_t{p[3]} << 24;
  return low | std::uint64_t{std::uint32_t{p[4]} | std::uint32_t{p[5]} << 8} << 32;
}

// (1 - w) a + w b for each byte, rounded, w in 1/256: every second byte at a time, so that each has
// 16 bits.
std::uint64_t blended(std::uint64_t a, std::uint64_t b, std::uint64_t w) {
  constexpr std::uint64_t even = 0x00ff00ff00ff00ff;
  constexpr std::uint64_t half = 0x0080008000800080;
  const std::uint64_t evens = (a & even) * (256 - w) + (b & even) * w + half;
  const std::uint64_t odds = (a >> 8 & even) * (256 - w) + (b >> 8 & even) * w + half;
  return (evens >> 8 & even) | (odds & ~even);
}

}  // namespace

Warp::Warp(int width, int height, int source_width, int source_height,
           const std::function<Point(const Point&)>& to_source)
    : width_(width), height_(height), source_width_(source_width), source_height_(source_height) {
  if (std::min(source_width, source_height) < 2 || std::max(source_width, source_height) > 65534) {
    throw std::invalid_argument("the source must have a width and a height of 2..65534 px");
  }
  places_.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      places_.push_back(place_of(to_source({static_cast<double>(u), static_cast<double>(v)})));
    }
  }
}

Warp::Place Warp::place_of(const Point& point) const {
  // A pixel reaches half a pixel beyond its centre.
  if (!(point.x >= -0.5 && point.x <= source_width_ - 0.5 && point.y >= -0.5 &&
        point.y <= source_height_ - 0.5)) {
    return {outside, 0, 0, 0};
  }
  const auto split = [](double x, int size) {
    const double inside = std::clamp(x, 0.0, size - 1.0);
    const int whole = std::min(static_cast<int>(inside), size - 2);
    return std::pair(static_cast<std::uint16_t>(whole),
                     static_cast<std::uint16_t>(std::lround(256 * (inside - whole))));
  };
  const auto [u, right] = split(point.x, source_width_);
  const auto [v, down] = split(point.y, source_height_);
  return {u, v, right, down};
}

void Warp::check_sizes(const ImageView& source, const WritableView& to) const {
  if (source.width != source_width_ || source.height != source_height_ || to.width != width_ ||
      to.height != height_) {
    throw std::invalid_argument("the images must have the sizes that the warp was made for");
  }
}

// The colour as the lowest three bytes.
std::uint64_t Warp::color_at(const ImageView& source, const Place& place) {
  const std::uint8_t* upper = source.row(place.v) + std::ptrdiff_t{3} * place.u;
  const std::uint64_t pair =
      blended(two_pixels(upper), two_pixels(upper + source.stride), place.down);
  return blended(pair, pair >> 24, place.right);
}

void Warp::apply(const ImageView& source, const WritableView& to) const {
  check_sizes(source, to);
  const Place* place = places_.data();
  for (int v = 0; v < height_; ++v) {
    std::uint8_t* pixel = to.row(v);
    for (int u = 0; u < width_; ++u, ++place, pixel += 3) {
      if (place->u == outside) {
        std::memset(pixel, grey, 3);
        continue;
      }
      const std::uint64_t color = color_at(source, *place);
      pixel[0] = static_cast<std::uint8_t>(color);
      pixel[1] = static_cast<std::uint8_t>(color >> 8);
      pixel[2] = static_cast<std::uint8_t>(color >> 16);
    }
  }
}

void Warp::lay_over(const ImageView& before_black, const ImageView& before_white,
                    const PixelBox& box, const WritableView& to) const {
  check_sizes(before_black, to);
  check_sizes(before_white, to);
  const Place* place = places_.data();
  for (int v = 0; v < height_; ++v) {
    std::uint8_t* pixel = to.row(v);
    for (int u = 0; u < width_; ++u, ++place, pixel += 3) {
      // A place reaches one pixel to the right, and down.
      if (place->u == outside || place->u + 1 < box.left || place->u >= box.right ||
          place->v + 1 < box.top || place->v >= box.bottom) {
        continue;
      }
      const std::uint64_t black = color_at(before_black, *place);
      const std::uint64_t white = color_at(before_white, *place);
      for (int channel = 0; channel < 3; ++channel) {
        const auto least = static_cast<int>(black >> 8 * channel & 0xff);
        const auto most = static_cast<int>(white >> 8 * channel & 0xff);
        const int through = std::max(most - least, 0) * pixel[channel];
        pixel[channel] = static_cast<std::uint8_t>(least + (through + 127) / 255);
      }
    }
  }
}

}  // namespace robsim
