#include "robsim/world/robot_image.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/base/simd/lanes.hpp"
#include "robsim/base/system.hpp"

namespace robsim::sprite {

namespace {

// Columns first <= u < last of a row.
struct Span {
  int first = 0;
  int last = 0;
};

constexpr int block = 64;  // pixels at a time, so that they stay in the first-level cache

// The columns u with 0 <= start + u step <= end, up to rounding.
Span span_between(double start, double step, double end, const Span& columns) {
  if (step == 0) return columns;
  const double a = -start / step;
  const double b = (end - start) / step;
  const double first = std::max<double>(std::min(a, b), columns.first);
  const double last = std::min<double>(std::max(a, b), columns.last - 1);
  if (!(first <= last)) return {columns.first, columns.first};
  return {static_cast<int>(first), static_cast<int>(last) + 1};
}

struct SamplePoints {
  int pixel[block];    // index in the sprite of the upper left one of four
  float right[block];  // fraction of the way to the others, 0..1
  float down[block];
};

ROBSIM_INLINE SamplePoints sample_points(const SpriteLine& line, int sprite_width, int first,
                                         int count) {
  // Relative to the upper left corner of the block single precision is accurate to 1e-5 px.
  const Point start = line.at(first);
  const Point end = line.at(first + count - 1);
  const int origin_left = static_cast<int>(std::min(start.x, end.x));
  const int origin_top = static_cast<int>(std::min(start.y, end.y));
  const int origin = origin_top * sprite_width + origin_left;
  const auto u0 = static_cast<float>(start.x - origin_left);
  const auto v0 = static_cast<float>(start.y - origin_top);
  // A single pixel has no next one: its step, of any size, must not count.
  const auto du = static_cast<float>(count > 1 ? line.step.x : 0);
  const auto dv = static_cast<float>(count > 1 ? line.step.y : 0);
  SamplePoints points;
  for (int i = 0; i < count; ++i) {
    const float u = u0 + static_cast<float>(i) * du;
    const float v = v0 + static_cast<float>(i) * dv;
    const int left = static_cast<int>(u);
    const int top = static_cast<int>(v);
    points.pixel[i] = origin + top * sprite_width + left;
    points.right[i] = u - static_cast<float>(left);
    points.down[i] = v - static_cast<float>(top);
  }
  return points;
}

using Four = simd::LanesOf<float, 16>;

// a + share (b - a)
ROBSIM_INLINE Four between(const Four& a, const Four& b, const Four& share) {
  return a + share * (b - a);
}

// Of so many columns. Copying four numbers is faster than three: the next pixel overwrites the
// fourth, and behind the last pixel there is room for one more.
ROBSIM_INLINE void sample_block(const Sprite& sprite, const SpriteLine& line, int first, int count,
                                float* colors, float* background_weight) {
  const SamplePoints points = sample_points(line, sprite.width, first, count);
  for (int i = 0; i < count; ++i) {
    const float* upper = sprite.pixels.data() + std::ptrdiff_t{4} * points.pixel[i];
    const float* lower = upper + std::ptrdiff_t{4} * sprite.width;
    const Four down = Four::all(points.down[i]);
    const Four left = between(Four::load(upper), Four::load(lower), down);
    const Four right = between(Four::load(upper + 4), Four::load(lower + 4), down);
    const Four pixel = between(left, right, Four::all(points.right[i]));
    pixel.store(colors + std::ptrdiff_t{3} * i);
    Four::all(pixel.at(3)).store(background_weight + std::ptrdiff_t{3} * i);
  }
}

// A loop that the compiler vectorises.
ROBSIM_INLINE void blend_block(const float* colors, const float* background_weight, int bytes,
                               float brightness, std::uint8_t* pixels) {
  // pixel = pixel (1 - alpha) + colour times alpha, which does not exceed 255
  for (int i = 0; i < bytes; ++i) {
    const float value =
        static_cast<float>(pixels[i]) * background_weight[i] + colors[i] * brightness;
    pixels[i] = static_cast<std::uint8_t>(value + 0.5F);
  }
}

// The columns within the sprite, before its last column and row, which `sample` may read because
// of rounding.
Span span_within(const Sprite& sprite, const SpriteLine& line, const Span& columns) {
  const int right = sprite.width - 2;
  const int bottom = sprite.height - 2;
  const Span across = span_between(line.start.x, line.step.x, right, columns);
  const Span down = span_between(line.start.y, line.step.y, bottom, columns);
  Span span{std::max(across.first, down.first), std::min(across.last, down.last)};
  const auto is_within = [&](int u) {
    const Point point = line.at(u);
    return point.x >= 0 && point.y >= 0 && point.x < right && point.y < bottom;
  };
  // Rounding preserves the order of the points: all lie within the sprite if both ends do.
  while (span.first < span.last && !is_within(span.first)) ++span.first;
  while (span.first < span.last && !is_within(span.last - 1)) --span.last;
  return span.first < span.last ? span : Span{columns.first, columns.first};
}

// Samples the sprite bilinearly in columns that lie within it.
Strip sample(const Sprite& sprite, const SpriteLine& line, const Span& columns) {
  const auto sample_columns = ROBSIM_PICK(sample_block);
  const int width = columns.last - columns.first;
  const std::size_t size = std::size_t{3} * static_cast<std::size_t>(width) + 1;
  Strip strip{columns.first, width, std::vector<float>(size), std::vector<float>(size)};
  for (int i = 0; i < width; i += block) {
    sample_columns(sprite, line, columns.first + i, std::min(block, width - i),
                   strip.colors.data() + std::ptrdiff_t{3} * i,
                   strip.background_weight.data() + std::ptrdiff_t{3} * i);
  }
  return strip;
}

Strip without_transparent_ends(const Strip& strip) {
  const auto shows = [&](int i) { return strip.background_weight[std::size_t{3} * i] < 1.0F; };
  int first = 0;
  int last = strip.width;
  while (first < last && !shows(first)) ++first;
  while (first < last && !shows(last - 1)) --last;
  const auto part = [&](const std::vector<float>& numbers) {
    return std::vector<float>(numbers.begin() + std::ptrdiff_t{3} * first,
                              numbers.begin() + std::ptrdiff_t{3} * last);
  };
  return {strip.left + first, last - first, part(strip.colors), part(strip.background_weight)};
}

// Blends a part of the strip over pixels. `brightness`: of the strip, within 0..1.
void blend(const Strip& strip, const Span& part, float brightness, std::uint8_t* pixels) {
  const std::ptrdiff_t first = std::ptrdiff_t{3} * part.first;
  ROBSIM_PICK(blend_block)
  (strip.colors.data() + first, strip.background_weight.data() + first,
   3 * (part.last - part.first), brightness, pixels);
}

// Samples and blends in one pass.
void blend(const Sprite& sprite, const SpriteLine& line, const Span& columns, float brightness,
           std::uint8_t* pixels) {
  const auto sample_columns = ROBSIM_PICK(sample_block);
  const auto blend_columns = ROBSIM_PICK(blend_block);
  float colors[3 * block + 1];
  float background_weight[3 * block + 1];
  for (int u = columns.first; u < columns.last; u += block) {
    const int count = std::min(block, columns.last - u);
    sample_columns(sprite, line, u, count, colors, background_weight);
    blend_columns(colors, background_weight, 3 * count, brightness, pixels);
    pixels += std::ptrdiff_t{3} * block;
  }
}

}  // namespace

}  // namespace robsim::sprite

namespace robsim {

using sprite::blend;
using sprite::sample;
using sprite::Span;
using sprite::span_within;
using sprite::SpriteLine;
using sprite::Strip;
using sprite::without_transparent_ends;

Sprite premultiplied(const std::uint8_t* rgba, int width, int height) {
  Sprite sprite{width, height, {}};
  sprite.pixels.resize(std::size_t{4} * width * height);
  for (std::size_t i = 0; i < sprite.pixels.size(); i += 4) {
    const float alpha = static_cast<float>(rgba[i + 3]) / 255.0F;
    for (std::size_t c = 0; c < 3; ++c) {
      sprite.pixels[i + c] = static_cast<float>(rgba[i + c]) * alpha;
    }
    sprite.pixels[i + 3] = 1.0F - alpha;
  }
  return sprite;
}

namespace {

// With a transparent rim: one pixel to the left and above, two to the right and below.
Sprite with_rim(const Sprite& sprite) {
  Sprite result{sprite.width + 3, sprite.height + 3, {}};
  result.pixels.assign(std::size_t{4} * result.width * result.height, 0.0F);
  for (std::size_t i = 3; i < result.pixels.size(); i += 4) result.pixels[i] = 1.0F;
  for (int v = 0; v < sprite.height; ++v) {
    std::copy_n(sprite.row(v), std::ptrdiff_t{4} * sprite.width, result.row(v + 1) + 4);
  }
  return result;
}

constexpr double maximum_radius = 20000;  // work-area px

// Bytes of all headings together, if they were squares; two thirds of them are transparent, and
// not kept. Of a robot that is too large for that the rows are made anew in each frame.
constexpr double most_memory = 1 << 30;

// Keeps positions far outside the view within the range of int.
Point near_the_view(const Point& pixel) {
  constexpr double far = 1e8;
  return {std::clamp(pixel.x, -far, far), std::clamp(pixel.y, -far, far)};
}

// Extends the box of what has been drawn by columns of the next row.
void add_row(PixelBox& box, const Span& columns, int v) {
  if (columns.first >= columns.last) return;
  if (box.empty()) box = {columns.first, v, columns.last, v};
  box = {std::min(box.left, columns.first), box.top, std::max(box.right, columns.last), v + 1};
}

// Calls draw(columns, brightness) for the lit part and for the part in the shadow.
template <typename Draw>
void draw_parts(const Span& columns, const Shadow& shadow, Draw draw) {
  const int edge = std::clamp(shadow.left, columns.first, columns.last);
  const auto factor = static_cast<float>(shadow.factor);
  if (columns.first < edge) draw(Span{columns.first, edge}, 1.0F);
  if (edge < columns.last) draw(Span{edge, columns.last}, factor);
}

}  // namespace

RobotImage::RobotImage(const Sprite& sprite, Point centre, double unit, double alignment,
                       int headings, const PlaneMap& camera)
    : sprite_(with_rim(sprite)),
      centre_{centre.x + 1, centre.y + 1},
      unit_(unit),
      alignment_(alignment),
      pixel_size_{camera.matrix()[0], camera.matrix()[4]},
      headings_(headings) {
  checked(unit, std::isfinite(unit) && unit > 0, "unit must be positive and finite (work-area px)");
  checked(headings, headings >= 0, "headings must be at least 0");
  const double du = std::max(centre_.x, sprite_.width - 2 - centre_.x);
  const double dv = std::max(centre_.y, sprite_.height - 2 - centre_.y);
  radius_ = unit_ * elementary::hypot(du, dv);
  if (!(radius_ < maximum_radius)) {
    throw std::invalid_argument("centre and unit must keep the robot's image within " +
                                std::to_string(static_cast<int>(maximum_radius)) +
                                " work-area px of its centre");
  }
  const PixelBox box = bounds({0, 0});
  const double pixels = 1.0 * (box.right - box.left) * (box.bottom - box.top);
  keeps_headings_ = pixels * 6 * sizeof(float) * headings <= most_memory;
  drawn_headings_ = std::make_unique<DrawnHeading[]>(static_cast<std::size_t>(headings));
}

PixelBox RobotImage::draw(const Point& pixel, double heading, const Shadow& shadow,
                          const WritableView& view) const {
  const Point position = near_the_view(pixel);
  return headings_ == 0 ? draw_turned(position, heading, shadow, view)
                        : draw_nearest_heading(position, heading, shadow, view);
}

PixelBox RobotImage::bounds(const Point& pixel) const {
  const double ru = radius_ / pixel_size_.x;
  const double rv = radius_ / pixel_size_.y;
  return {static_cast<int>(std::floor(pixel.x - ru)), static_cast<int>(std::floor(pixel.y - rv)),
          static_cast<int>(std::ceil(pixel.x + ru)) + 1,
          static_cast<int>(std::ceil(pixel.y + rv)) + 1};
}

SpriteLine RobotImage::line(const Point& pixel, const Point& ahead, int v) const {
  // The position in the sprite: the offset from the robot's centre, rotated back.
  const Point scale{pixel_size_.x / unit_, pixel_size_.y / unit_};
  const double dx = -pixel.x * scale.x;
  const double dy = (v - pixel.y) * scale.y;
  return {{centre_.x + dx * ahead.x + dy * ahead.y, centre_.y - dx * ahead.y + dy * ahead.x},
          {scale.x * ahead.x, -scale.x * ahead.y}};
}

Point RobotImage::direction(double heading) const {
  const auto [sin, cos] = elementary::sin_cos(heading + alignment_);
  return {cos, sin};
}

const std::vector<Strip>& RobotImage::drawn_heading(int i) const {
  DrawnHeading& drawn = drawn_headings_[static_cast<std::size_t>(i)];
  std::call_once(drawn.is_made, [&] {
    const PixelBox box = bounds({0, 0});
    const Point ahead = direction(2 * pi * i / headings_);
    std::vector<Strip> strips;
    for (int v = box.top; v < box.bottom; ++v) strips.push_back(make_strip(ahead, v, box));
    drawn.strips = std::move(strips);
  });
  return drawn.strips;
}

Strip RobotImage::make_strip(const Point& ahead, int v, const PixelBox& box) const {
  const SpriteLine row_line = line({0, 0}, ahead, v);
  const Span columns = span_within(sprite_, row_line, {box.left, box.right});
  return without_transparent_ends(sample(sprite_, row_line, columns));
}

PixelBox RobotImage::draw_turned(const Point& pixel, double heading, const Shadow& shadow,
                                 const WritableView& view) const {
  const PixelBox box = intersection(bounds(pixel), view.box());
  if (box.empty()) return {};
  PixelBox drawn;
  const Point ahead = direction(heading);
  for (int v = box.top; v < box.bottom; ++v) {
    const SpriteLine row_line = line(pixel, ahead, v);
    const Span columns = span_within(sprite_, row_line, {box.left, box.right});
    add_row(drawn, columns, v);
    draw_parts(columns, shadow, [&](const Span& part, float brightness) {
      blend(sprite_, row_line, part, brightness, view.row(v) + std::ptrdiff_t{3} * part.first);
    });
  }
  return drawn;
}

PixelBox RobotImage::draw_nearest_heading(const Point& pixel, double heading, const Shadow& shadow,
                                          const WritableView& view) const {
  const int nearest = static_cast<int>(std::lround(wrap_angle(heading) / (2 * pi) * headings_));
  const int i = (nearest + headings_) % headings_;
  const std::vector<Strip>* const kept = keeps_headings_ ? &drawn_heading(i) : nullptr;
  const Point ahead = kept ? Point{} : direction(2 * pi * i / headings_);
  Strip made;
  const int u = static_cast<int>(std::round(pixel.x));
  const int v = static_cast<int>(std::round(pixel.y));
  const PixelBox around = bounds({0, 0});
  const PixelBox box = intersection(
      {u + around.left, v + around.top, u + around.right, v + around.bottom}, view.box());
  if (box.empty()) return {};
  PixelBox drawn;
  for (int row = box.top; row < box.bottom; ++row) {
    if (!kept) made = make_strip(ahead, row - v, around);
    const Strip& strip = kept ? (*kept)[static_cast<std::size_t>(row - v - around.top)] : made;
    const int left = u + strip.left;
    const Span columns{std::clamp(left, box.left, box.right),
                       std::clamp(left + strip.width, box.left, box.right)};
    add_row(drawn, columns, row);
    draw_parts(columns, shadow, [&](const Span& part, float brightness) {
      blend(strip, {part.first - left, part.last - left}, brightness,
            view.row(row) + std::ptrdiff_t{3} * part.first);
    });
  }
  return drawn;
}

}  // namespace robsim
