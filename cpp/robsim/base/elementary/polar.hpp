#pragma once

namespace robsim::elementary {

/// The angle of the point (x, y) from the x axis (rad), in [-pi, pi], with an error of less than
/// one unit in the last place. Zeros, infinities and NaN as the C standard has them (annex F).
/// Method: atan(t) = atan(k/16) + atan((t - k/16)/(1 + t k/16)), the quotient in twice the
/// precision of a double, then a polynomial (Muller, Elementary Functions, 2016, ch. 6).
double atan2(double y, double x);

/// sqrt(x^2 + y^2) without overflow or underflow on the way, with an error of less than one unit in
/// the last place.
double hypot(double x, double y);

}  // namespace robsim::elementary
