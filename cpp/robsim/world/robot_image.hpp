#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "robsim/base/geometry.hpp"
#include "robsim/imaging/image.hpp"
#include "robsim/imaging/plane_map.hpp"

namespace robsim {

/// An image with transparency: 4 floats per pixel, R, G, B (0..255) times alpha, and 1 - alpha, the
/// weight of the background.
struct Sprite {
  int width = 0;
  int height = 0;
  std::vector<float> pixels;

  const float* row(int v) const { return pixels.data() + std::ptrdiff_t{4} * width * v; }
  float* row(int v) { return pixels.data() + std::ptrdiff_t{4} * width * v; }
};

/// From RGBA8 pixels with straight alpha, without gaps between rows.
Sprite premultiplied(const std::uint8_t* rgba, int width, int height);

}  // namespace robsim

namespace robsim::sprite {

/// A row of an image in sprite coordinates: the position of column 0, and the step per column.
struct SpriteLine {
  Point start;
  Point step;

  Point at(int u) const { return {start.x + u * step.x, start.y + u * step.y}; }
};

/// Pixels to blend over a part of a row, from column `left` on. For each byte of the image: the
/// colour added to it, and the weight of the background.
struct Strip {
  int left = 0;
  int width = 0;
  std::vector<float> colors;
  std::vector<float> background_weight;
};

}  // namespace robsim::sprite

namespace robsim {

/// The part of the view that lies in the shadow: columns from `left` on, darkened to `factor`.
struct Shadow {
  int left = 0;
  double factor = 1;
};

/// The robot seen from above, in any heading.
/// With headings > 0 it is drawn in the nearest of that many headings at the nearest whole pixel,
/// as in the program of 2008; with headings = 0 at its exact position and heading.
class RobotImage {
 public:
  /// `centre` is the robot's centre in sprite pixels, `unit` the size of a sprite pixel in
  /// work-area px, `alignment` (rad, clockwise) the rotation of the image that makes the robot face
  /// +x, `camera` the map of the frames to draw into.
  RobotImage(const Sprite& sprite, Point centre, double unit, double alignment, int headings,
             const PlaneMap& camera);

  /// Draws the robot, its centre at `pixel`, and returns the box of the pixels changed.
  PixelBox draw(const Point& pixel, double heading, const Shadow& shadow,
                const WritableView& view) const;

  int headings() const { return headings_; }

 private:
  // A strip for each row around the robot's centre, made when the heading is first shown, and kept
  // unless all of them would take too much memory.
  struct DrawnHeading {
    std::once_flag is_made;
    std::vector<sprite::Strip> strips;
  };

  PixelBox bounds(const Point& pixel) const;
  Point direction(double heading) const;  // of the image: cosine and sine
  sprite::SpriteLine line(const Point& pixel, const Point& ahead, int v) const;
  const std::vector<sprite::Strip>& drawn_heading(int i) const;
  sprite::Strip make_strip(const Point& ahead, int v, const PixelBox& box) const;
  PixelBox draw_turned(const Point& pixel, double heading, const Shadow& shadow,
                       const WritableView& view) const;
  PixelBox draw_nearest_heading(const Point& pixel, double heading, const Shadow& shadow,
                                const WritableView& view) const;

  Sprite sprite_;  // with a transparent rim
  Point centre_;
  double unit_;
  double alignment_;
  Point pixel_size_;  // work-area px per camera pixel
  double radius_;     // of the sprite's farthest corner, work-area px
  int headings_;
  bool keeps_headings_;
  std::unique_ptr<DrawnHeading[]> drawn_headings_;
};

}  // namespace robsim
