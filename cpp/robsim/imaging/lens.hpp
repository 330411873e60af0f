#pragma once

#include "robsim/geometry/pose.hpp"

namespace robsim {

/// A lens that distorts: what an ideal one would show at the distance r from the centre of the
/// frame, in halves of its diagonal, appears at the distance r (1 + k1 r^2 + k2 r^4).
/// Source: D. C. Brown, Close-range camera calibration, 1971; radial terms.
class Lens {
 public:
  /// For frames of width x height px. Throws std::invalid_argument unless the coefficients are
  /// finite, and every pixel of the frame shows one ideal one.
  Lens(double k1, double k2, int width, int height);

  /// Where the frame shows what an ideal lens would show at this pixel.
  Point distorted(const Point& ideal) const;

  /// Back again, for a pixel of the frame.
  Point ideal(const Point& distorted) const;

 private:
  double distorted_radius(double r) const { return r * (1 + r * r * (k1_ + r * r * k2_)); }
  Point moved(const Point& pixel, double factor) const;

  double k1_;
  double k2_;
  Point centre_;
  double unit_;     // px of r = 1
  double largest_;  // ideal radius up to which the distorted one grows with it
};

}  // namespace robsim
