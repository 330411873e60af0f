#include "robsim/vision/fit/edge_model.hpp"

#include <algorithm>
#include <cmath>

#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/base/simd/lanes.hpp"
#include "robsim/base/simd/target.hpp"

namespace robsim::fit {

namespace {

using simd::HalvedLanesOf;
using simd::LanesOf;

constexpr float steepness = 0.27F;  // of the step, by q

template <typename Floats>
struct Shift {
  Floats x, y, turn, grow, per_px;

  ROBSIM_INLINE Shift(const EdgePixels& pixels, const EdgeShift& shift)
      : x(Floats::all(static_cast<float>(shift.x))),
        y(Floats::all(static_cast<float>(shift.y))),
        turn(Floats::all(static_cast<float>(shift.turn))),
        grow(Floats::all(static_cast<float>(shift.grow))),
        per_px(Floats::all(static_cast<float>(pixels.scale / shift.blur))) {}

  // q = scale/blur (d - n . shift + turn dd/dturn + grow)
  ROBSIM_INLINE Floats q(const EdgeBlock& block, int i) const {
    const Floats moved =
        Floats::load(block.normal_x + i) * x + Floats::load(block.normal_y + i) * y;
    const Floats turned = Floats::load(block.turn + i) * turn;
    return (Floats::load(block.distance + i) - moved + turned + grow) * per_px;
  }
};

struct CoverSums {
  double ones, coverage, squares;      // 1, T, T^2
  double color[3], color_coverage[3];  // y, y T
  double products[3][3];               // y y', c <= d
};

template <typename Floats>
ROBSIM_INLINE void cover_all(EdgePixels& pixels, const EdgeShift& edge_shift, CoverSums& result) {
  const Shift<Floats> shift(pixels, edge_shift);
  const Floats zero = Floats::all(0), half = Floats::all(0.5F), one = Floats::all(1);
  Floats ones = zero, coverage = zero, squares = zero;
  Floats color[3] = {zero, zero, zero};
  Floats color_coverage[3] = {zero, zero, zero};
  Floats products[3][3];
  for (auto& row : products) {
    for (Floats& sum : row) sum = zero;
  }
  for (EdgeBlock& block : pixels.blocks) {
    for (int i = 0; i < EdgeBlock::size; i += Floats::count) {
      // T = 6 t^5 - 15 t^4 + 10 t^3,  T' = steepness 30 t^2 (1 - t)^2,  t = 1/2 + steepness q
      const Floats t = within(half + Floats::all(steepness) * shift.q(block, i), zero, one);
      const Floats t2 = t * t;
      const Floats step = t2 * t * (Floats::all(10) + t * (Floats::all(6) * t - Floats::all(15)));
      const Floats rest = one - t;
      step.store(block.coverage + i);
      (Floats::all(30 * steepness) * t2 * (rest * rest)).store(block.slope + i);
      const Floats root = Floats::load(block.weight + i);
      const Floats weight = root * root;
      ones = ones + weight;
      coverage = coverage + weight * step;
      squares = squares + weight * step * step;
      for (int c = 0; c < 3; ++c) {
        const Floats y = weight * Floats::load(block.color[c] + i);
        color[c] = color[c] + y;
        color_coverage[c] = color_coverage[c] + y * step;
        for (int d = c; d < 3; ++d) {
          products[c][d] = products[c][d] + y * Floats::load(block.color[d] + i);
        }
      }
    }
  }
  result.ones = sum_of(ones);
  result.coverage = sum_of(coverage);
  result.squares = sum_of(squares);
  for (int c = 0; c < 3; ++c) {
    result.color[c] = sum_of(color[c]);
    result.color_coverage[c] = sum_of(color_coverage[c]);
    for (int d = c; d < 3; ++d) result.products[c][d] = sum_of(products[c][d]);
  }
}

// The columns of a block: T' times the derivatives of q; z; 1 and T. All times the root of the
// weight.
constexpr int z_column = parameters, one_column = parameters + 1, t_column = parameters + 2;
constexpr int columns_count = parameters + 3;
using Columns = float[columns_count][EdgeBlock::size];

template <typename Floats>
struct Line {
  Floats weights[3], gain, constant;

  ROBSIM_INLINE explicit Line(const ChannelWeights& channels)
      : gain(Floats::all(static_cast<float>(channels.gain))),
        constant(Floats::all(static_cast<float>(channels.constant))) {
    for (std::size_t c = 0; c < 3; ++c)
      weights[c] = Floats::all(static_cast<float>(channels.of[c]));
  }
};

template <typename Floats>
ROBSIM_INLINE void fill(const EdgeBlock& block, const Shift<Floats>& shift,
                        const Line<Floats>& line, Columns& columns) {
  for (int i = 0; i < EdgeBlock::size; i += Floats::count) {
    const Floats root = Floats::load(block.weight + i);
    const Floats coverage = Floats::load(block.coverage + i);
    const Floats slope = root * Floats::load(block.slope + i);
    (slope * Floats::load(block.normal_x + i)).store(columns[0] + i);
    (slope * Floats::load(block.normal_y + i)).store(columns[1] + i);
    (slope * Floats::load(block.turn + i)).store(columns[2] + i);
    slope.store(columns[3] + i);
    (slope * shift.q(block, i)).store(columns[4] + i);
    // z = m . y - m . level - gain T
    Floats z = Floats::all(0) - line.constant - line.gain * coverage;
    for (int c = 0; c < 3; ++c) z = z + line.weights[c] * Floats::load(block.color[c] + i);
    (root * z).store(columns[z_column] + i);
    root.store(columns[one_column] + i);
    (root * coverage).store(columns[t_column] + i);
  }
}

// The products of the first columns with themselves and all others.
using Products = double[parameters][columns_count];

template <typename Floats>
ROBSIM_INLINE void multiply(const EdgePixels& pixels, const EdgeShift& edge_shift,
                            const ChannelWeights& weights, Products& products) {
  const Shift<Floats> shift(pixels, edge_shift);
  const Line<Floats> line(weights);
  Floats sums[parameters][columns_count];
  for (auto& row : sums) {
    for (Floats& sum : row) sum = Floats::all(0);
  }
  alignas(32) Columns columns;
  for (const EdgeBlock& block : pixels.blocks) {
    fill(block, shift, line, columns);
    for (int i = 0; i < parameters; ++i) {
      for (int j = i; j < columns_count; ++j) {
        Floats sum = sums[i][j];
        for (int k = 0; k < EdgeBlock::size; k += Floats::count) {
          sum = sum + Floats::load(columns[i] + k) * Floats::load(columns[j] + k);
        }
        sums[i][j] = sum;
      }
    }
  }
  for (int i = 0; i < parameters; ++i) {
    for (int j = i; j < columns_count; ++j) products[i][j] = sum_of(sums[i][j]);
  }
}

}  // namespace

bool cover(EdgePixels& pixels, const EdgeShift& shift, Appearance& appearance) {
  CoverSums sums;
  ROBSIM_PICK(cover_all<HalvedLanesOf<float>>, cover_all<LanesOf<float>>)(pixels, shift, sums);
  appearance.ones = sums.ones;
  appearance.coverage = sums.coverage;
  appearance.coverage_squares = sums.squares;
  // The line y = level + contrast T with the least squares.
  const double determinant = sums.ones * sums.squares - sums.coverage * sums.coverage;
  if (!(determinant > 1e-3 * sums.ones * sums.ones)) return false;
  for (std::size_t c = 0; c < 3; ++c) {
    const double y = sums.color[c];
    const double yt = sums.color_coverage[c];
    appearance.contrast[c] = (sums.ones * yt - sums.coverage * y) / determinant;
    appearance.level[c] = (sums.squares * y - sums.coverage * yt) / determinant;
  }
  // r'r = y'y - level 1'y - contrast T'y. The levels are whole numbers from the middle of their
  // range, so that little is lost in the difference.
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t d = c; d < 3; ++d) {
      const double explained =
          appearance.level[c] * sums.color[d] + appearance.contrast[c] * sums.color_coverage[d];
      appearance.residuals[c][d] = appearance.residuals[d][c] = sums.products[c][d] - explained;
    }
    appearance.residuals[c][c] = std::max(0.0, appearance.residuals[c][c]);
  }
  return true;
}

EdgeSums sums_of(const EdgePixels& pixels, const EdgeShift& shift, const Appearance& appearance,
                 const ChannelWeights& weights) {
  Products products;
  ROBSIM_PICK(multiply<HalvedLanesOf<float>>, multiply<LanesOf<float>>)
  (pixels, shift, weights, products);
  EdgeSums sums;
  sums.slope = products[3][3];
  const double ones = appearance.ones, t = appearance.coverage,
               squares = appearance.coverage_squares;
  const double determinant = ones * squares - t * t;
  for (std::size_t i = 0; i < parameters; ++i) {
    for (std::size_t j = i; j < parameters; ++j) {
      // D'PD = D'D - D'K (K'K)^-1 K'D,  K = (1, T)
      const double known = (squares * products[i][one_column] * products[j][one_column] -
                            t * (products[i][one_column] * products[j][t_column] +
                                 products[i][t_column] * products[j][one_column]) +
                            ones * products[i][t_column] * products[j][t_column]) /
                           determinant;
      sums.information[i][j] = sums.information[j][i] = products[i][j] - known;
    }
    sums.gradient[i] = products[i][z_column];
  }
  return sums;
}

}  // namespace robsim::fit
