#include "robsim/world/robot_image.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/system.hpp"

namespace robsim {

using sprite::Span;
using sprite::SpriteLine;
using sprite::Strip;

namespace {

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
  if (!(std::isfinite(unit) && unit > 0)) {
    throw std::invalid_argument("unit must be positive and finite (work-area px), got " +
                                to_text(unit));
  }
  if (headings < 0) {
    throw std::invalid_argument("headings must be at least 0, got " + std::to_string(headings));
  }
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
