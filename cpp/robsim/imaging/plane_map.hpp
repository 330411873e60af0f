#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "robsim/base/geometry.hpp"
#include "robsim/imaging/image.hpp"
#include "robsim/imaging/intrinsics.hpp"

namespace robsim {

/// Pixels of a frame (u right, v down; integer = pixel centre) <-> positions on the work area.
/// A homography; for the simulated camera it is a scaling and a shift. With a camera's intrinsics
/// it is that of the ideal pixels, and NaN where the lens shows nothing.
class PlaneMap {
 public:
  using Matrix = std::array<double, 9>;  // row by row

  /// The identity.
  PlaneMap();

  /// `to_world` maps (u, v, 1) to (x, y, 1) times a number.
  /// Throws std::invalid_argument if it is not finite or has no inverse.
  explicit PlaneMap(const Matrix& to_world,
                    const std::optional<Intrinsics>& intrinsics = std::nullopt);

  /// A camera of width x height pixels that sees an area of area_width x area_height, its top left
  /// corner moved by `origin` (work-area px).
  static PlaneMap scaled(int width, int height, double area_width, double area_height,
                         Point origin = {});

  /// The only homography that takes each of four pixels to its position (work-area px); of more
  /// points, the one with the least squared distances. Throws std::invalid_argument if there are
  /// fewer, or not as many of both; if too many lie on a line; and if the positions are in another
  /// order than the pixels; or if the lens shows nothing at a pixel.
  static PlaneMap from_points(const std::vector<Point>& pixels, const std::vector<Point>& positions,
                              const std::optional<Intrinsics>& intrinsics = std::nullopt);

  /// The map to what lies `height` work-area px above the floor, as the homography K [r1 r2 t] of
  /// the floor gives it: K [r1 r2 t + height n], n pointing up, to the camera. Throws
  /// std::invalid_argument without intrinsics, and if the camera is not above that height.
  PlaneMap at_height(double height) const;

  /// The pixel at which an ideal lens would show what this one does; NaN where it shows nothing.
  Point ideal(const Point& pixel) const { return intrinsics_ ? intrinsics_->ideal(pixel) : pixel; }

  Point to_world(const Point& pixel) const;
  Point to_pixel(const Point& position) const;

  /// Work-area px^2 per square pixel of the frame at this pixel.
  double area_scale(const Point& pixel) const;

  const Matrix& matrix() const { return to_world_; }
  const Intrinsics* intrinsics() const { return intrinsics_.get(); }  // null: none

 private:
  Matrix to_world_;
  Matrix to_pixel_;
  std::shared_ptr<const Intrinsics> intrinsics_;  // shared: each frame has a copy of the map
};

/// The homography from pixels to positions with the least sum of squared distances on the work
/// area, by Gauss-Newton iterations from the linear solution; coordinates are normalised as in
/// Hartley, "In defense of the eight-point algorithm", PAMI 1997. At least five points.
/// Throws std::invalid_argument if they do not determine it, or do not belong together.
PlaneMap::Matrix fit_homography(const std::vector<Point>& pixels,
                                const std::vector<Point>& positions);

/// What the camera delivers: everything the robot half knows about the world.
struct Frame {
  Image image;
  std::optional<double> t;          // s; none of its own: it is one sample time after the last one
  std::optional<double> t_arrival;  // s, by the same clock: when it reached this computer
  std::optional<double> epoch;      // s, monotonic: t = 0 of this clock
  std::int64_t index = 0;
  PlaneMap plane_map;
  int headings = 0;  // that the robot is drawn in, at whole pixels; 0 = any, as a camera sees it
};

}  // namespace robsim
