#include "robsim/vision/fit/light_slope.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/base/simd/lanes.hpp"
#include "robsim/base/simd/target.hpp"

namespace robsim::fit {

namespace {

// What a slope must be: so many variances, and a share of the contrast that is more than the rim of
// a marker gives.
constexpr double clear_slope = 12;
constexpr double visible_slope = 0.045;

// Sums over pixels of e = w . r, in terms of w; the normals of the edge stand for the place around
// the middle of the marker.
struct SlopeSums {
  double products[4];  // e f, f = normal_x, normal_y, T normal_x, T normal_y
  double squares[4];   // f^2
};

using simd::HalvedLanesOf;
using simd::LanesOf;
using Weights = std::array<float, 3>;

template <typename Floats>
ROBSIM_INLINE void add_slopes(const EdgeFit& marker, const Weights& weights, SlopeSums& result) {
  const Appearance& appearance = marker.appearance;
  float constant = 0, rise = 0;  // e = w . y - w . level - w . contrast T
  for (std::size_t c = 0; c < 3; ++c) {
    constant += weights[c] * static_cast<float>(appearance.level[c]);
    rise += weights[c] * static_cast<float>(appearance.contrast[c]);
  }
  Floats products[4], squares[4];
  for (int f = 0; f < 4; ++f) products[f] = squares[f] = Floats::all(0);
  for (const EdgeBlock& block : marker.pixels.blocks) {
    for (int i = 0; i < EdgeBlock::size; i += Floats::count) {
      const Floats t = Floats::load(block.coverage + i);
      Floats e = Floats::all(0) - Floats::all(constant) - Floats::all(rise) * t;
      for (std::size_t c = 0; c < 3; ++c) {
        e = e + Floats::all(weights[c]) * Floats::load(block.color[c] + i);
      }
      const Floats weight = Floats::load(block.weight + i);
      const Floats x = weight * Floats::load(block.normal_x + i);
      const Floats y = weight * Floats::load(block.normal_y + i);
      const Floats columns[4] = {x, y, t * x, t * y};
      for (int f = 0; f < 4; ++f) {
        products[f] = products[f] + e * columns[f];
        squares[f] = squares[f] + columns[f] * columns[f];
      }
    }
  }
  for (int f = 0; f < 4; ++f) {
    result.products[f] = sum_of(products[f]);
    result.squares[f] = sum_of(squares[f]);
  }
}

void add_slopes_baseline(const EdgeFit& marker, const Weights& weights, SlopeSums& sums) {
  add_slopes<HalvedLanesOf<float>>(marker, weights, sums);
}

#if ROBSIM_HAS_AVX2_CODE
ROBSIM_AVX2 void add_slopes_avx2(const EdgeFit& marker, const Weights& weights, SlopeSums& sums) {
  add_slopes<LanesOf<float>>(marker, weights, sums);
}
#endif

}  // namespace

bool has_light_slope(const EdgeFit& marker) {
  const Appearance& appearance = marker.appearance;
  // w_c = light of the marker / variance_c: what a change of light changes most
  Weights weights;
  std::array<double, 3> w;
  double rise = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double light = EdgePixels::grey + appearance.level[c] + appearance.contrast[c];
    w[c] = std::max(light, 1.0) / (appearance.residuals[c][c] / appearance.ones + rounding);
    rise += w[c] * std::fabs(appearance.contrast[c]);
  }
  double variance = 0;  // of e = w . r
  for (std::size_t c = 0; c < 3; ++c) {
    weights[c] = static_cast<float>(w[c]);
    variance += w[c] * w[c] * rounding;
    for (std::size_t d = 0; d < 3; ++d)
      variance += w[c] * w[d] * appearance.residuals[c][d] / appearance.ones;
  }
  SlopeSums sums;
  ROBSIM_PICK(add_slopes_baseline, add_slopes_avx2)(marker, weights, sums);
  for (int f = 0; f < 4; ++f) {
    const double slope = std::fabs(sums.products[f]) / sums.squares[f];
    const double deviations = slope * slope * sums.squares[f] / variance;
    if (deviations > clear_slope && slope > visible_slope * rise) return true;
  }
  return false;
}

}  // namespace robsim::fit
