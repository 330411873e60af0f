#pragma once

#include <cmath>

#include "robsim/base/elementary/coefficients.hpp"

namespace robsim::elementary {

/// A number as the sum of a double and a rest, which is at most half a unit in its last place.
struct DoubleDouble {
  double high = 0;
  double low = 0;
};

/// The exact sum of two numbers: Knuth, The Art of Computer Programming 2, 4.2.2, theorem B.
inline DoubleDouble exact_sum(double a, double b) {
  const double sum = a + b;
  const double from_b = sum - a;
  return {sum, (a - (sum - from_b)) + (b - from_b)};
}

/// The upper 26 bits of a number and the rest, for |a| < 2^996: Veltkamp 1968.
inline DoubleDouble split(double a) {
  const double scaled = 134217729 * a;  // 2^27 + 1
  const double high = scaled - (scaled - a);
  return {high, a - high};
}

/// The exact product of two numbers, unless it overflows or its rest underflows: Dekker 1971.
inline DoubleDouble exact_product(double a, double b) {
  const DoubleDouble x = split(a);
  const DoubleDouble y = split(b);
  const double product = a * b;
  return {product, ((x.high * y.high - product) + x.high * y.low + x.low * y.high) + x.low * y.low};
}

/// The value of a polynomial, the constant coefficient first: Horner's rule.
template <int size>
inline double polynomial(const double (&coefficients)[size], double x) {
  double value = coefficients[size - 1];
  for (int i = size - 2; i >= 0; --i) value = value * x + coefficients[i];
  return value;
}

/// The integer next to a number of at most 2^51, as a double: the last bit of the sum is worth 1.
inline double nearest_integer(double x) {
  constexpr double one_and_a_half_times_2_to_52 = 6755399441055744.0;
  return (x + one_and_a_half_times_2_to_52) - one_and_a_half_times_2_to_52;
}

/// An angle less the nearest multiple of pi/2.
struct ReducedAngle {
  DoubleDouble rest;  // within +-pi/4, but for rounding
  int quadrant = 0;   // the multiple, modulo 4
};

/// Below it the multiples of pi/2 have less than 20 bits.
constexpr double largest_by_parts = 1e6;

/// Cody and Waite: no double is nearer than 2^-62 to a multiple of pi/2 but 0. Each difference is
/// exact, or rounded at 2^-132.
inline ReducedAngle reduced_by_parts(double angle) {
  const double n = nearest_integer(angle * two_over_pi);
  const double first = angle - n * pi_2_parts[0];
  const DoubleDouble second = exact_sum(first, -n * pi_2_parts[1]);
  const DoubleDouble third = exact_sum(second.high, -n * pi_2_parts[2]);
  const double rest = (second.low + third.low) - n * pi_2_parts[3];
  return {exact_sum(third.high, rest), static_cast<int>(n) & 3};
}

/// Payne and Hanek, for any finite angle: in integers, of those digits of 2/pi that count.
ReducedAngle reduced_by_digits(double angle);

/// The angle (rad), any finite number, reduced with a relative error of less than 2^-63.
inline ReducedAngle reduced(double angle) {
  return std::abs(angle) < largest_by_parts ? reduced_by_parts(angle) : reduced_by_digits(angle);
}

}  // namespace robsim::elementary
