#pragma once

#include <cstdint>
#include <vector>

#include "robsim/geometry/pose.hpp"
#include "robsim/imaging/image.hpp"
#include "robsim/imaging/plane_map.hpp"

namespace robsim {

/// A picture with transparency: 4 floats a pixel (R, G, B, A in 0..255), colours times alpha.
struct Sprite {
  int width = 0;
  int height = 0;
  std::vector<float> rgba;

  const float* row(int v) const { return rgba.data() + std::ptrdiff_t{4} * width * v; }
  float* row(int v) { return rgba.data() + std::ptrdiff_t{4} * width * v; }
};

/// From RGBA8 pixels, colours not yet multiplied with alpha, without gaps between rows.
Sprite premultiplied(const std::uint8_t* rgba, int width, int height);

/// The part of the view that lies in the shadow: columns from `left` on, darkened to `factor`.
struct Shadow {
  int left = 0;
  double factor = 1;
};

/// The robot seen from above, in any heading.
/// With phases > 0 it is shown in the nearest of so many headings, at the nearest whole pixel, as
/// in the program of 2008; with phases = 0 at its exact place and heading.
class RobotImage {
 public:
  /// `centre` is the robot's centre in sprite pixels, `unit` the work-area px that a sprite pixel
  /// stands for, `alignment` (rad, clockwise) what turns the picture so that the robot faces +x,
  /// `camera` the map of the frames to draw into.
  RobotImage(const Sprite& sprite, Point centre, double unit, double alignment, int phases,
             const PlaneMap& camera);

  /// Draws the robot, its centre at `pixel`, and returns the pixels that it may have touched.
  PixelBox draw(const Point& pixel, double heading, const Shadow& shadow, Image& image) const;

 private:
  PixelBox reach(const Point& pixel) const;
  void sample(const Point& pixel, double heading, const PixelBox& box, int v, float* rgba) const;
  PixelBox draw_turned(const Point& pixel, double heading, const Shadow& shadow,
                       Image& image) const;
  PixelBox draw_phase(const Point& pixel, double heading, const Shadow& shadow, Image& image) const;

  Sprite sprite_;  // with a transparent rim of one pixel
  Point centre_;
  double unit_;
  double alignment_;
  Point pixel_size_;  // work-area px per camera pixel
  double radius_;     // of the sprite's farthest corner, work-area px
  std::vector<Sprite> phases_;
};

}  // namespace robsim
