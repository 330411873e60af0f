#include "robsim/base/elementary/polar.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "robsim/base/elementary/coefficients.hpp"
#include "robsim/base/elementary/double_double.hpp"

namespace robsim::elementary {

namespace {

constexpr double huge = 0x1.0p+480;  // from here on, and below its inverse, squares are not exact
constexpr double negligible = 0x1.0p-64;  // a ratio whose square does not count

// Both numbers times a power of two, exactly, so that squares and products of them are numbers too.
struct Scaled {
  double larger;
  double smaller;
  double unit;
};

Scaled scaled(double a, double b) {
  const double larger = std::max(a, b);
  const double smaller = std::min(a, b);
  if (larger > huge) return {larger / 0x1.0p+600, smaller / 0x1.0p+600, 0x1.0p+600};
  if (larger < 1 / huge) return {larger * 0x1.0p+600, smaller * 0x1.0p+600, 0x1.0p-600};
  return {larger, smaller, 1};
}

DoubleDouble quotient(const DoubleDouble& a, const DoubleDouble& b) {
  const double q = a.high / b.high;
  const DoubleDouble product = exact_product(q, b.high);
  const double rest = ((a.high - product.high) - product.low) + (a.low - q * b.low);
  return {q, rest / b.high};
}

// atan(y/x) for 0 <= y <= x
DoubleDouble arc_tangent(double y, double x) {
  constexpr int steps = 16;
  const double k = nearest_integer(steps * (y / x));
  const double step = k / steps;
  // t = (y - step x)/(x + step y)
  const DoubleDouble step_x = exact_product(step, x);
  const DoubleDouble step_y = exact_product(step, y);
  const DoubleDouble above = exact_sum(y - step_x.high, -step_x.low);
  const DoubleDouble sum = exact_sum(x, step_y.high);
  const DoubleDouble t = quotient(above, {sum.high, sum.low + step_y.low});
  const auto i = static_cast<int>(k);
  const double z = t.high * t.high;
  const DoubleDouble angle_and_t = exact_sum(angle[i], t.high);
  const double rest = t.high * z * polynomial(arc_tangent_part, z) + (t.low + angle_rest[i]);
  return exact_sum(angle_and_t.high, angle_and_t.low + rest);
}

DoubleDouble difference(const double (&whole)[2], const DoubleDouble& part) {
  const DoubleDouble high = exact_sum(whole[0], -part.high);
  return {high.high, high.low + (whole[1] - part.low)};
}

// The angle of a point with y >= 0 and not NaN.
double upper_angle(double y, double x) {
  const double width = std::abs(x);
  const bool is_left = std::signbit(x);
  if (std::isinf(y) && std::isinf(x)) return is_left ? 3 * (pi_2[0] / 2) : pi_2[0] / 2;
  if (y == 0 || std::isinf(x)) return is_left ? pi_[0] : 0;
  if (width == 0 || std::isinf(y) || width / y < negligible) return pi_2[0];
  if (y / width < negligible) return is_left ? pi_[0] : y / width;
  const Scaled s = scaled(y, width);
  DoubleDouble result = arc_tangent(s.smaller, s.larger);
  if (y > width) result = difference(pi_2, result);
  if (is_left) result = difference(pi_, result);
  return result.high + result.low;
}

}  // namespace

double atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return x + y;
  return std::copysign(upper_angle(std::abs(y), x), y);
}

double hypot(double x, double y) {
  const double width = std::abs(x);
  const double height = std::abs(y);
  if (std::isinf(x) || std::isinf(y)) return std::numeric_limits<double>::infinity();
  if (std::isnan(x) || std::isnan(y)) return x + y;
  const Scaled s = scaled(width, height);
  if (s.smaller <= negligible * s.larger) return width + height;
  // h - (h^2 - larger^2 - smaller^2)/2h: one step of Newton's method, its difference exact
  const double h = std::sqrt(s.larger * s.larger + s.smaller * s.smaller);
  const DoubleDouble a = exact_product(s.larger, s.larger);
  const DoubleDouble b = exact_product(s.smaller, s.smaller);
  const DoubleDouble square = exact_product(h, h);
  const double excess = ((square.high - a.high) - b.high) + ((square.low - a.low) - b.low);
  return (h - excess / (2 * h)) * s.unit;
}

}  // namespace robsim::elementary
