#include "robsim/vision/fit/edge_fit.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

namespace robsim::fit {

namespace {

constexpr double shading = 10;  // levels by which all channels may be lighter at once

// Residuals that are further from 0 than about this have little weight: in standard deviations, and
// as a share of the contrast for pictures without noise.
constexpr double robust_deviations = 3;
constexpr double robust_contrast = 0.06;

float median_of(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

bool EdgeFit::update(const EdgeShift& shift) {
  weights.gain = 0;
  if (pixels.count < 12 || !cover(pixels, shift, appearance)) return false;
  // C: covariance of the residuals over R, G, B. Two numbers are fitted to each channel.
  using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  Eigen::Matrix3d covariance =
      Eigen::Map<const Matrix>(appearance.residuals[0].data()) / std::max(1.0, appearance.ones - 2);
  covariance.diagonal().array() += rounding;
  // weights = (C + shading^2 1 1')^-1 contrast: light and shadow change all channels alike.
  const Eigen::Map<const Eigen::Vector3d> contrast(appearance.contrast.data());
  const Eigen::Map<const Eigen::Vector3d> level(appearance.level.data());
  Eigen::Map<Eigen::Vector3d> m(weights.of.data());
  m = (covariance + Eigen::Matrix3d::Constant(shading * shading)).inverse() * contrast;
  variance = m.dot(covariance * m);
  const double gain = contrast.dot(m);
  if (!(variance > 0 && std::isfinite(gain) && gain > 0)) return false;
  weights.gain = gain;
  weights.constant = level.dot(m);
  sums = sums_of(pixels, shift, appearance, weights);
  return true;
}

std::vector<float> EdgeFit::residuals() const {
  std::vector<float> all(pixels.blocks.size() * EdgeBlock::size);
  float* z = all.data();
  const auto number = [](double value) { return static_cast<float>(value); };
  const float m[3] = {number(weights.of[0]), number(weights.of[1]), number(weights.of[2])};
  const float constant = number(weights.constant);
  const float rise = number(weights.gain);  // z = m . y - m . level - gain T
  for (const EdgeBlock& block : pixels.blocks) {
    for (int i = 0; i < EdgeBlock::size; ++i) {
      const float y =
          m[0] * block.color[0][i] + m[1] * block.color[1][i] + m[2] * block.color[2][i];
      z[i] = y - constant - rise * block.coverage[i];
    }
    z += EdgeBlock::size;
  }
  std::fill(all.begin() + pixels.count, all.end(), 0.0F);
  return all;
}

double EdgeFit::usual_residual() const {
  std::vector<float> sizes = residuals();
  sizes.resize(static_cast<std::size_t>(pixels.count));
  for (float& size : sizes) size = std::fabs(size);
  return static_cast<double>(median_of(sizes)) / weights.gain;
}

void EdgeFit::weigh_by_residual() {
  const std::vector<float> z = residuals();
  // The median of |z| of a normal distribution is 0.6745 standard deviations.
  const double deviation = std::max(usual_residual() / 0.6745, robust_contrast);
  const auto limit = static_cast<float>(robust_deviations * deviation * weights.gain);
  for (std::size_t i = 0; i < static_cast<std::size_t>(pixels.count); ++i) {
    // root of the weight 1 / (1 + (z/limit)^2)^2
    const float share = z[i] / limit;
    pixels.blocks[i / EdgeBlock::size].weight[i % EdgeBlock::size] = 1 / (1 + share * share);
  }
}

}  // namespace robsim::fit
