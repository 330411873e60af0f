#pragma once

#include <array>

#include "robsim/base/geometry.hpp"

namespace robsim {

/// A camera's focal lengths, principal point and distortion: where it shows what an ideal camera,
/// without distortion, would show at a pixel. Pixels as everywhere (integer = pixel centre).
/// At the ideal (x, y) = ((u - cx) / fx, (v - cy) / fy), r^2 = x^2 + y^2, the lens shows
///   x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)
///   y' = y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y
/// as far as that grows with r. What is farther out it does not show: both ways give NaN.
/// Source: D. C. Brown, Close-range camera calibration, 1971; the terms and their order are those
/// of OpenCV.
class Intrinsics {
 public:
  using Distortion = std::array<double, 5>;  // k1, k2, p1, p2, k3

  /// The derivatives of a map of (u, v): of its first component by u and v, then of its second.
  using Jacobian = std::array<double, 4>;

  /// `focal` and `centre`, the principal point, in px. Throws std::invalid_argument unless all are
  /// finite, and the focal lengths above 0.
  Intrinsics(const Point& focal, const Point& centre, const Distortion& distortion = {});

  const Point& focal() const { return focal_; }
  const Point& centre() const { return centre_; }
  const Distortion& distortion() const { return distortion_; }

  /// Where frames show what an ideal camera would show at this pixel.
  Point distorted(const Point& ideal) const;

  /// Back again, to rounding.
  Point ideal(const Point& distorted) const;

  /// The derivatives of `ideal` at the pixel that it leads to.
  Jacobian ideal_derivatives(const Point& ideal) const;

 private:
  // A place in units of the focal lengths, and the derivatives there, which are symmetric.
  struct Shown {
    Point at;
    double xx, xy, yy;

    bool is_in_order() const { return xx + yy > 0 && xx * yy > xy * xy; }
  };

  Point normalised(const Point& p) const {
    return {(p.x - centre_.x) / focal_.x, (p.y - centre_.y) / focal_.y};
  }
  Point pixel(const Point& p) const {
    return {centre_.x + p.x * focal_.x, centre_.y + p.y * focal_.y};
  }
  bool is_within(const Point& p) const { return p.x * p.x + p.y * p.y < largest_; }
  Shown shown(const Point& ideal) const;

  Point focal_;
  Point centre_;
  Distortion distortion_;
  bool is_distorting_;
  double largest_;  // r^2 up to which the distorted radius grows with r, without p1 and p2
};

}  // namespace robsim
