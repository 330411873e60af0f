#include "robsim/imaging/lens.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace robsim {

namespace {

constexpr double far_away = 10;  // in halves of the diagonal: no frame shows more

// Not std::hypot, whose last digit differs between C libraries.
double length(double x, double y) { return std::sqrt(x * x + y * y); }

// The smallest r > 0 at which the distorted radius stops growing:
// d/dr (r + k1 r^3 + k2 r^5) = 1 + 3 k1 q + 5 k2 q^2 = 0, q = r^2
double turning_radius(double k1, double k2) {
  const double discriminant = 9 * k1 * k1 - 20 * k2;
  if (discriminant < 0) return far_away;
  // Of a q^2 + b q + 1 the roots as 2 / (-b -+ root): no division by a = 0.
  const double root = std::sqrt(discriminant);
  double smallest = far_away * far_away;
  for (const double divisor : {-3 * k1 - root, -3 * k1 + root}) {
    if (divisor > 0) smallest = std::min(smallest, 2 / divisor);
  }
  return std::sqrt(smallest);
}

}  // namespace

Lens::Lens(double k1, double k2, int width, int height)
    : k1_(k1),
      k2_(k2),
      centre_{(width - 1) / 2.0, (height - 1) / 2.0},
      unit_(length(width, height) / 2),
      largest_(turning_radius(k1, k2)) {
  if (!std::isfinite(k1) || !std::isfinite(k2)) {
    throw std::invalid_argument("k1 and k2 must be finite");
  }
  if (!(distorted_radius(largest_) >= 1)) {
    throw std::invalid_argument(
        "k1 and k2 must keep the order of the pixels from the centre to the corners: with these, "
        "the lens folds the picture over within the frame");
  }
}

Point Lens::moved(const Point& pixel, double factor) const {
  return {centre_.x + (pixel.x - centre_.x) * factor, centre_.y + (pixel.y - centre_.y) * factor};
}

Point Lens::distorted(const Point& ideal) const {
  const double r = length(ideal.x - centre_.x, ideal.y - centre_.y) / unit_;
  return r == 0 ? ideal : moved(ideal, distorted_radius(r) / r);
}

Point Lens::ideal(const Point& distorted) const {
  const double wanted = length(distorted.x - centre_.x, distorted.y - centre_.y) / unit_;
  if (wanted == 0) return distorted;
  double low = 0;
  double high = largest_;
  // Newton's method, by bisection where it would leave the interval.
  double r = std::min(wanted, largest_);
  for (int i = 0; i < 60 && high - low > 1e-12; ++i) {
    const double error = distorted_radius(r) - wanted;
    (error > 0 ? high : low) = r;
    const double next = r - error / (1 + r * r * (3 * k1_ + 5 * r * r * k2_));
    if (std::abs(next - r) < 1e-13) break;
    r = next > low && next < high ? next : (low + high) / 2;
  }
  return moved(distorted, r / wanted);
}

}  // namespace robsim
