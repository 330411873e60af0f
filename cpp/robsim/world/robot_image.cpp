#include "robsim/world/robot_image.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace robsim {

namespace {

constexpr double most_reach = 20000;  // work-area px

Sprite with_rim(const Sprite& sprite) {
  Sprite result{sprite.width + 2, sprite.height + 2, {}};
  result.rgba.assign(std::size_t{4} * result.width * result.height, 0.0F);
  for (int v = 0; v < sprite.height; ++v) {
    std::copy_n(sprite.row(v), std::ptrdiff_t{4} * sprite.width, result.row(v + 1) + 4);
  }
  return result;
}

// pixel = pixel (1 - alpha) + colour times alpha
void blend(const float* rgba, int count, float brightness, std::uint8_t* pixels) {
  for (int i = 0; i < count; ++i, rgba += 4, pixels += 3) {
    const float rest = 1.0F - rgba[3] / 255.0F;
    for (int c = 0; c < 3; ++c) {
      const float value = static_cast<float>(pixels[c]) * rest + rgba[c] * brightness;
      pixels[c] = static_cast<std::uint8_t>(std::min(value + 0.5F, 255.0F));
    }
  }
}

void blend_row(const float* rgba, const PixelBox& box, int v, const Shadow& shadow, Image& image) {
  const int edge = std::clamp(shadow.left, box.left, box.right);
  std::uint8_t* pixels = image.row(v);
  blend(rgba, edge - box.left, 1.0F, pixels + std::ptrdiff_t{3} * box.left);
  blend(rgba + std::ptrdiff_t{4} * (edge - box.left), box.right - edge,
        static_cast<float>(shadow.factor), pixels + std::ptrdiff_t{3} * edge);
}

// Keeps places far outside the view within the range of int.
Point near_the_view(const Point& pixel) {
  constexpr double far = 1e8;
  return {std::clamp(pixel.x, -far, far), std::clamp(pixel.y, -far, far)};
}

}  // namespace

Sprite premultiplied(const std::uint8_t* rgba, int width, int height) {
  Sprite sprite{width, height, {}};
  sprite.rgba.resize(std::size_t{4} * width * height);
  for (std::size_t i = 0; i < sprite.rgba.size(); i += 4) {
    const float alpha = static_cast<float>(rgba[i + 3]) / 255.0F;
    for (std::size_t c = 0; c < 3; ++c) {
      sprite.rgba[i + c] = static_cast<float>(rgba[i + c]) * alpha;
    }
    sprite.rgba[i + 3] = rgba[i + 3];
  }
  return sprite;
}

RobotImage::RobotImage(const Sprite& sprite, Point centre, double unit, double alignment,
                       int phases, const PlaneMap& camera)
    : sprite_(with_rim(sprite)),
      centre_{centre.x + 1, centre.y + 1},
      unit_(unit),
      alignment_(alignment),
      pixel_size_{camera.matrix()[0], camera.matrix()[4]} {
  if (!(std::isfinite(unit) && unit > 0)) {
    throw std::invalid_argument("unit must be positive and finite (work-area px), got " +
                                std::to_string(unit));
  }
  if (phases < 0) {
    throw std::invalid_argument("phases must be at least 0, got " + std::to_string(phases));
  }
  const double du = std::max(centre_.x, sprite_.width - 1 - centre_.x);
  const double dv = std::max(centre_.y, sprite_.height - 1 - centre_.y);
  radius_ = unit_ * std::hypot(du, dv);
  if (!(radius_ < most_reach)) {
    throw std::invalid_argument("centre and unit must keep the robot's picture within " +
                                std::to_string(static_cast<int>(most_reach)) +
                                " work-area px of its centre");
  }
  for (int i = 0; i < phases; ++i) {
    const PixelBox box = reach({0, 0});
    Sprite phase{box.right - box.left, box.bottom - box.top, {}};
    phase.rgba.resize(std::size_t{4} * phase.width * phase.height);
    for (int v = 0; v < phase.height; ++v) {
      sample({0, 0}, 2 * pi * i / phases, box, v + box.top, phase.row(v));
    }
    phases_.push_back(std::move(phase));
  }
}

PixelBox RobotImage::draw(const Point& pixel, double heading, const Shadow& shadow,
                          Image& image) const {
  const Point place = near_the_view(pixel);
  return phases_.empty() ? draw_turned(place, heading, shadow, image)
                         : draw_phase(place, heading, shadow, image);
}

PixelBox RobotImage::reach(const Point& pixel) const {
  const double ru = radius_ / pixel_size_.x;
  const double rv = radius_ / pixel_size_.y;
  return {static_cast<int>(std::floor(pixel.x - ru)), static_cast<int>(std::floor(pixel.y - rv)),
          static_cast<int>(std::ceil(pixel.x + ru)) + 1,
          static_cast<int>(std::ceil(pixel.y + rv)) + 1};
}

void RobotImage::sample(const Point& pixel, double heading, const PixelBox& box, int v,
                        float* rgba) const {
  const double cos = std::cos(heading + alignment_);
  const double sin = std::sin(heading + alignment_);
  const double dy = (v - pixel.y) * pixel_size_.y / unit_;
  for (int u = box.left; u < box.right; ++u, rgba += 4) {
    // The place in the sprite: the offset from the robot's centre, turned back.
    const double dx = (u - pixel.x) * pixel_size_.x / unit_;
    const double su = centre_.x + dx * cos + dy * sin;
    const double sv = centre_.y - dx * sin + dy * cos;
    std::fill_n(rgba, 4, 0.0F);
    if (!(su >= 0 && sv >= 0 && su < sprite_.width - 1 && sv < sprite_.height - 1)) continue;
    const int left = static_cast<int>(su);
    const int top = static_cast<int>(sv);
    const auto fu = static_cast<float>(su - left);
    const auto fv = static_cast<float>(sv - top);
    const float* upper = sprite_.row(top) + std::ptrdiff_t{4} * left;
    const float* lower = sprite_.row(top + 1) + std::ptrdiff_t{4} * left;
    for (int c = 0; c < 4; ++c) {
      const float above = upper[c] + fu * (upper[c + 4] - upper[c]);
      const float below = lower[c] + fu * (lower[c + 4] - lower[c]);
      rgba[c] = above + fv * (below - above);
    }
  }
}

PixelBox RobotImage::draw_turned(const Point& pixel, double heading, const Shadow& shadow,
                                 Image& image) const {
  const PixelBox box = intersection(reach(pixel), image.box());
  if (box.empty()) return {};
  std::vector<float> row(std::size_t{4} * (box.right - box.left));
  for (int v = box.top; v < box.bottom; ++v) {
    sample(pixel, heading, box, v, row.data());
    blend_row(row.data(), box, v, shadow, image);
  }
  return box;
}

PixelBox RobotImage::draw_phase(const Point& pixel, double heading, const Shadow& shadow,
                                Image& image) const {
  const int count = static_cast<int>(phases_.size());
  const int nearest = static_cast<int>(std::lround(wrap_angle(heading) / (2 * pi) * count));
  const Sprite& phase = phases_[static_cast<std::size_t>((nearest + count) % count)];
  const Point whole{std::round(pixel.x), std::round(pixel.y)};
  const PixelBox all = reach(whole);
  const PixelBox box = intersection(all, image.box());
  if (box.empty()) return {};
  for (int v = box.top; v < box.bottom; ++v) {
    const float* rgba = phase.row(v - all.top) + std::ptrdiff_t{4} * (box.left - all.left);
    blend_row(rgba, box, v, shadow, image);
  }
  return box;
}

}  // namespace robsim
