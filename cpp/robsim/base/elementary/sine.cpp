#include "robsim/base/elementary/sine.hpp"

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

}  // namespace robsim::elementary
