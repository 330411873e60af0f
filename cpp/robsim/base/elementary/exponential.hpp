#pragma once

namespace robsim::elementary {

/// e to the power of x, with an error of less than one unit in the last place.
/// Method: exp(x) = 2^k exp(r), |r| <= log(2)/2, then a polynomial (Muller, Elementary Functions,
/// 2016, ch. 11).
double exp(double x);

/// The natural logarithm, with an error of less than one unit in the last place. Of 0: -infinity,
/// of less: NaN.
/// Method: log(2^k m) = k log 2 + 2 atanh((m - 1)/(m + 1)), then a polynomial (there).
double log(double x);

}  // namespace robsim::elementary
