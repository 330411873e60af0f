#include "robsim/imaging/intrinsics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace robsim {

namespace {

constexpr double far_away = 1e4;  // r^2: 89.4 degrees off the optical axis
constexpr int most_steps = 100;
constexpr double smallest_share = 1e-3;  // of a Newton step
constexpr double rounding = 1e-30;       // squared misfit
constexpr double largest_misfit = 1e-20;
constexpr Point nowhere{std::numeric_limits<double>::quiet_NaN(),
                        std::numeric_limits<double>::quiet_NaN()};

// Where a polynomial that is above 0 at `low`, and not at `high`, has its zero between them.
template <typename Polynomial>
double zero_between(double low, double high, const Polynomial& value) {
  for (int i = 0; i < 200; ++i) {
    const double middle = (low + high) / 2;
    (value(middle) > 0 ? low : high) = middle;
  }
  return low;
}

// The smallest q = r^2 at which the distorted radius stops growing:
// d/dr (r + k1 r^3 + k2 r^5 + k3 r^7) = 1 + 3 k1 q + 5 k2 q^2 + 7 k3 q^3 = 0
double turning_point(double k1, double k2, double k3) {
  const auto growth = [&](double q) { return 1 + q * (3 * k1 + q * (5 * k2 + q * 7 * k3)); };
  // Between the zeros of its derivative, 3 k1 + 10 k2 q + 21 k3 q^2 = 0, it has one zero at most:
  // q = -3 k1 / (5 k2 -+ root), which does not divide by k3 = 0, and its fellow.
  std::array<double, 3> ends{far_away, far_away, far_away};
  const double discriminant = 25 * k2 * k2 - 63 * k1 * k3;
  if (discriminant >= 0) {
    const double sum = -(5 * k2 + std::copysign(std::sqrt(discriminant), k2));
    const auto within = [](double q) { return q > 0 && q < far_away ? q : far_away; };
    ends = {within(sum / (21 * k3)), within(3 * k1 / sum), far_away};
    std::sort(ends.begin(), ends.end());
  }
  double low = 0;
  for (const double end : ends) {
    if (!(growth(end) > 0)) return zero_between(low, end, growth);
    low = end;
  }
  return far_away;
}

double squared_distance(const Point& a, const Point& b) {
  return (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y);
}

}  // namespace

Intrinsics::Intrinsics(const Point& focal, const Point& centre, const Distortion& distortion)
    : focal_(focal),
      centre_(centre),
      distortion_(distortion),
      is_distorting_(distortion != Distortion{}),
      largest_(turning_point(distortion[0], distortion[1], distortion[4])) {
  for (const double value : {focal.x, focal.y, centre.x, centre.y}) {
    if (!std::isfinite(value)) throw std::invalid_argument("matrix must be finite");
  }
  if (!(focal.x > 0 && focal.y > 0)) {
    throw std::invalid_argument("matrix must have focal lengths above 0 (px)");
  }
  for (const double value : distortion) {
    if (!std::isfinite(value)) throw std::invalid_argument("distortion must be finite");
  }
}

Intrinsics::Shown Intrinsics::shown(const Point& ideal) const {
  const auto& [k1, k2, p1, p2, k3] = distortion_;
  const auto& [x, y] = ideal;
  const double q = x * x + y * y;
  const double radial = 1 + q * (k1 + q * (k2 + q * k3));
  const double growth = 2 * (k1 + q * (2 * k2 + q * 3 * k3));  // of `radial`, by q, twice
  return {{x * radial + 2 * p1 * x * y + p2 * (q + 2 * x * x),
           y * radial + p1 * (q + 2 * y * y) + 2 * p2 * x * y},
          radial + x * x * growth + 2 * p1 * y + 6 * p2 * x,
          x * y * growth + 2 * p1 * x + 2 * p2 * y,
          radial + y * y * growth + 6 * p1 * y + 2 * p2 * x};
}

Point Intrinsics::distorted(const Point& ideal) const {
  if (!is_distorting_) return ideal;
  const Point place = normalised(ideal);
  if (!is_within(place)) return nowhere;
  const Shown there = shown(place);
  return there.is_in_order() ? pixel(there.at) : nowhere;
}

Point Intrinsics::ideal(const Point& distorted) const {
  if (!is_distorting_) return distorted;
  const Point wanted = normalised(distorted);
  Point place = wanted;
  if (!is_within(place)) {
    const double inwards = 0.99 * std::sqrt(largest_ / (wanted.x * wanted.x + wanted.y * wanted.y));
    place = {wanted.x * inwards, wanted.y * inwards};
  }
  Shown there = shown(place);
  double misfit = squared_distance(there.at, wanted);
  // Newton's method; a step that leads out, or to nothing better, is halved.
  for (int i = 0; i < most_steps && misfit > rounding; ++i) {
    const double ex = wanted.x - there.at.x, ey = wanted.y - there.at.y;
    const double determinant = there.xx * there.yy - there.xy * there.xy;
    const Point step{(there.yy * ex - there.xy * ey) / determinant,
                     (there.xx * ey - there.xy * ex) / determinant};
    bool is_better = false;
    for (double share = 1; share > smallest_share && !is_better; share /= 2) {
      const Point next{place.x + share * step.x, place.y + share * step.y};
      const Shown shown_next = shown(next);
      const double rest = squared_distance(shown_next.at, wanted);
      is_better = is_within(next) && shown_next.is_in_order() && rest < misfit;
      if (!is_better) continue;
      place = next;
      there = shown_next;
      misfit = rest;
    }
    if (!is_better) break;
  }
  return misfit <= largest_misfit && there.is_in_order() ? pixel(place) : nowhere;
}

Intrinsics::Jacobian Intrinsics::ideal_derivatives(const Point& ideal) const {
  if (!is_distorting_) return {1, 0, 0, 1};
  const Shown there = shown(normalised(ideal));
  const double determinant = there.xx * there.yy - there.xy * there.xy;
  return {there.yy / determinant, -there.xy / determinant * focal_.x / focal_.y,
          -there.xy / determinant * focal_.y / focal_.x, there.xx / determinant};
}

}  // namespace robsim
