#pragma once

#include <cstdint>

/// Functions that give the same bits on every machine: of + - * / and sqrt alone, which IEEE 754
/// rounds in one way, where those of the C library differ in the last digit.
namespace robsim::elementary {

struct SinCos {
  double sin;
  double cos;
};

/// Sine and cosine of an angle (rad), each with an error of less than one unit in the last place
/// for angles of any size. Of infinity: NaN, as those of the C library.
/// Method: the angle less a multiple of pi/2 in more than twice the precision of a double (Cody and
/// Waite, Software Manual for the Elementary Functions, 1980; for large ones Payne and Hanek 1983),
/// then a polynomial.
SinCos sin_cos(double angle);
double sin(double angle);
double cos(double angle);

/// e to the power of x, with an error of less than one unit in the last place.
/// Method: exp(x) = 2^k exp(r), |r| <= log(2)/2, then a polynomial (Muller, Elementary Functions,
/// 2016, ch. 11).
double exp(double x);

/// The natural logarithm, with an error of less than one unit in the last place. Of 0: -infinity,
/// of less: NaN.
/// Method: log(2^k m) = k log 2 + 2 atanh((m - 1)/(m + 1)), then a polynomial (there).
double log(double x);

/// The angle of the point (x, y) from the x axis (rad), in [-pi, pi], with an error of less than
/// one unit in the last place. Zeros, infinities and NaN as the C standard has them (annex F).
/// Method: atan(t) = atan(k/16) + atan((t - k/16)/(1 + t k/16)), the quotient in twice the
/// precision of a double, then a polynomial (Muller, Elementary Functions, 2016, ch. 6).
double atan2(double y, double x);

/// sqrt(x^2 + y^2) without overflow or underflow on the way, with an error of less than one unit in
/// the last place.
double hypot(double x, double y);

}  // namespace robsim::elementary

namespace robsim {

/// The random number at position `counter` of the stream `seed`: a pure function, so that the draws
/// of one step or frame do not depend on earlier ones.
/// Method: SplitMix64 (Steele, Lea and Flood 2014), used as a hash of seed and counter.
std::uint64_t random_bits(std::uint64_t seed, std::uint64_t counter);

/// The same as a number in [0, 1) with 53 random bits.
double random_uniform(std::uint64_t seed, std::uint64_t counter);

/// A number of the standard normal distribution, from the positions 2 counter and 2 counter + 1.
double random_normal(std::uint64_t seed, std::uint64_t counter);

}  // namespace robsim
