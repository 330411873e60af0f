#include "robsim/base/elementary/exponential.hpp"

#include <cmath>
#include <limits>

#include "robsim/base/elementary/coefficients.hpp"
#include "robsim/base/elementary/double_double.hpp"

namespace robsim::elementary {

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

}  // namespace robsim::elementary
