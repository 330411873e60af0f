#pragma once

#include <array>

#include "robsim/vision/fit/edge_pixels.hpp"

namespace robsim::fit {

// The model of a pixel i at the edge of a marker, per channel c:
//
//   y_ic = level_c + contrast_c T(q_i) + noise,   q_i = scale d_i / blur
//
// with the distance d_i from the edge, and the share T of the pixel that the marker covers: a
// quintic step of a blurred edge, whose slope is that of a normal distribution but for 2 %.

/// How a marker lies otherwise than where its pixels were gathered, to first order.
struct EdgeShift {
  double x = 0;     // work-area px, in the robot's frame
  double y = 0;     // px
  double turn = 0;  // rad
  double grow = 0;  // px by which it is larger all around
  double blur = 1;  // standard deviation (frame px)
};

/// Per channel, of the pixels' least-squares line over T.
struct Appearance {
  std::array<double, 3> level{};
  std::array<double, 3> contrast{};                     // of the marker from what is around it
  std::array<std::array<double, 3>, 3> residuals{};     // r'r, of what the line leaves
  double ones = 0, coverage = 0, coverage_squares = 0;  // sums of 1, T, T^2; all by weight
};

/// How the channels are weighed: z = weights . r is what decides on the pose.
struct ChannelWeights {
  std::array<double, 3> of{};
  double gain = 0;      // weights . contrast
  double constant = 0;  // weights . level: z = weights . y - constant - gain T
};

/// How T changes with x, y, turn, grow and the logarithm of 1/blur, but for the factor scale/blur
/// of the first four.
constexpr int parameters = 5;

/// Sums over the pixels, with T' for the slope of T by q:
struct EdgeSums {
  double slope = 0;                                                      // T'^2
  std::array<std::array<double, parameters>, parameters> information{};  // D'PD
  std::array<double, parameters> gradient{};                             // D'z
};

/// Writes T and its slope to the pixels, and fits the appearance. False if all T are the same.
bool cover(EdgePixels& pixels, const EdgeShift& shift, Appearance& appearance);

/// The sums over pixels that `cover` has been to; P is the projection off 1 and T.
EdgeSums sums_of(const EdgePixels& pixels, const EdgeShift& shift, const Appearance& appearance,
                 const ChannelWeights& weights);

}  // namespace robsim::fit
