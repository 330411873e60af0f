#include "robsim/base/elementary/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "robsim/base/elementary/coefficients.hpp"
#include "robsim/base/elementary/reduced_angle.hpp"

namespace robsim::elementary {

namespace {

constexpr double pi_4 = pi_2[0] / 2;
constexpr double tiny = 0x1.0p-27;  // sin x = x - x^3/6, which is x

// sin(r + rest) = r + r^3 S(r^2) + rest cos r
double sine_of(const DoubleDouble& r, double z) {
  return r.high + (r.high * z * polynomial(sine_part, z) + r.low * (1 - z / 2));
}

// cos(r + rest) = 1 - r^2/2 + r^4 C(r^2) - rest sin r; what 1 - r^2/2 is rounded by is added again
double cosine_of(const DoubleDouble& r, double z) {
  const double half = z / 2;
  const double near = 1 - half;
  return near + (((1 - near) - half) + (z * z * polynomial(cosine_part, z) - r.high * r.low));
}

ReducedAngle reduced_if_needed(double angle) {
  if (std::abs(angle) <= pi_4) return {{angle, 0}, 0};
  return reduced(angle);
}

}  // namespace

SinCos sin_cos(double angle) {
  if (std::abs(angle) < tiny) return {angle, 1};
  if (!std::isfinite(angle)) {
    constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
    return {not_a_number, not_a_number};
  }
  const auto [r, quadrant] = reduced_if_needed(angle);
  const double z = r.high * r.high;
  const double sine = sine_of(r, z);
  const double cosine = cosine_of(r, z);
  const bool is_odd = (quadrant & 1) != 0;
  const SinCos first{is_odd ? cosine : sine, is_odd ? sine : cosine};
  return {(quadrant & 2) != 0 ? -first.sin : first.sin,
          ((quadrant + 1) & 2) != 0 ? -first.cos : first.cos};
}

double sin(double angle) { return sin_cos(angle).sin; }

double cos(double angle) { return sin_cos(angle).cos; }

namespace {
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double sqrt_half = 0.70710678118654752;
}  // namespace

double exp(double x) {
  if (std::isnan(x)) return x;
  if (x > 710) return infinity;
  if (x < -746) return 0;
  const double k = nearest_integer(x * one_over_log_2);
  const double low = k * log_2_parts[1];
  const DoubleDouble r = exact_sum(x - k * log_2_parts[0], -low);
  // exp(r) = 1 + r + r^2 E(r)
  const DoubleDouble near = exact_sum(1, r.high);
  const double rest = r.high * r.high * polynomial(exponential_part, r.high) + r.low;
  return std::ldexp(near.high + (near.low + rest), static_cast<int>(k));
}

double log(double x) {
  if (!(x > 0)) return x == 0 ? -infinity : not_a_number;
  if (std::isinf(x)) return x;
  int k;
  double m = std::frexp(x, &k);
  if (m < sqrt_half) {
    m *= 2;
    --k;
  }
  // log(1 + f) = f - s (f - s^2 L(s^2)), s = f/(2 + f), L the polynomial;  s f = f - 2 s
  const double f = m - 1;
  const double s = f / (2 + f);
  const double z = s * s;
  const DoubleDouble whole = exact_sum(k * log_2_parts[0], f);
  const double rest = z * polynomial(logarithm_part, z) - f;
  return whole.high + (whole.low + (s * rest + k * log_2_parts[1]));
}

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

namespace robsim {

namespace {

constexpr std::uint64_t golden = 0x9E3779B97F4A7C15ULL;

std::uint64_t mix(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31);
}

}  // namespace

std::uint64_t random_bits(std::uint64_t seed, std::uint64_t counter) {
  // The seed is mixed first: otherwise neighbouring seeds give shifted copies of one stream.
  return mix(mix(seed + golden) + (counter + 1) * golden);
}

double random_uniform(std::uint64_t seed, std::uint64_t counter) {
  return static_cast<double>(random_bits(seed, counter) >> 11) * 0x1.0p-53;
}

double random_normal(std::uint64_t seed, std::uint64_t counter) {
  constexpr double two_pi = 6.283185307179586;
  // sqrt(-2 ln a) cos(2 pi b), a in (0, 1], b in [0, 1): Box and Muller 1958
  const double a = 1 - random_uniform(seed, 2 * counter);
  const double b = random_uniform(seed, 2 * counter + 1);
  return std::sqrt(-2 * elementary::log(a)) * elementary::cos(two_pi * b);
}

}  // namespace robsim
