#pragma once

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

}  // namespace robsim::elementary
