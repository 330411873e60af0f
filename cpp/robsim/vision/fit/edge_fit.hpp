#pragma once

#include <vector>

#include "robsim/vision/fit/edge_model.hpp"

namespace robsim::fit {

constexpr double rounding = 1.0 / 12;  // variance of a rounded level

/// Pixels of a marker in one light, and what the model makes of them.
struct EdgeFit {
  std::size_t marker = 0;  // whose they are
  EdgePixels pixels;
  Appearance appearance;
  EdgeSums sums;

  ChannelWeights weights;  // no gain: the pixels tell nothing
  double variance = 0;     // of z

  /// False if they tell nothing: no edge is in the picture.
  bool update(const EdgeShift& shift);

  /// (contrast to noise)^2 per unit of information; 0 where they tell nothing.
  double precision() const { return weights.gain > 0 ? weights.gain * weights.gain / variance : 0; }

  /// z of every pixel, block by block; 0 where there is none.
  std::vector<float> residuals() const;

  /// The median size of the residuals, as a share of the contrast.
  double usual_residual() const;

  /// Weighs pixels anew, less the less they fit. Method: Geman and McClure (1987).
  void weigh_by_residual();
};

/// How much larger the variance of the pose is than residuals without correlation would make it, at
/// least 1: by the correlation of residuals that are up to 2 px apart, where it is more than
/// chance, and that of the slopes there.
double variance_factor(const std::vector<EdgeFit>& parts);

}  // namespace robsim::fit
