#include "robsim/vision/fit/edge_model.hpp"

#include <cmath>

#include "robsim/simd/cpu_path.hpp"
#include "robsim/simd/lanes.hpp"
#include "robsim/simd/target.hpp"

namespace robsim::fit {

namespace {

using simd::LanesOf;
using Floats = LanesOf<float>;

constexpr float steepness = 0.27F;  // of the step, by q

// Columns of numbers per pixel, for a block.
constexpr int most_columns = 10;
using Columns = float[most_columns][EdgeBlock::size];

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

// The sums of the products of columns [begin, end) with [other, others).
template <int begin, int end, int other, int others>
ROBSIM_INLINE void add_products(const Columns& columns, Floats (*sums)[most_columns]) {
  for (int i = begin; i < end; ++i) {
    for (int j = i > other ? i : other; j < others; ++j) {
      Floats sum = sums[i][j];
      for (int k = 0; k < EdgeBlock::size; k += Floats::count) {
        sum = sum + Floats::load(columns[i] + k) * Floats::load(columns[j] + k);
      }
      sums[i][j] = sum;
    }
  }
}

struct CoverSums {
  double ones, coverage, squares;      // 1, T, T^2
  double color[3], color_coverage[3];  // y, y T
};

ROBSIM_INLINE void cover_all(EdgePixels& pixels, const EdgeShift& edge_shift, CoverSums& result) {
  const Shift shift(pixels, edge_shift);
  const Floats zero = Floats::all(0), half = Floats::all(0.5F), one = Floats::all(1);
  Floats ones = zero, coverage = zero, squares = zero;
  Floats color[3] = {zero, zero, zero};
  Floats color_coverage[3] = {zero, zero, zero};
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
      const Floats weighted = weight * step;
      ones = ones + weight;
      coverage = coverage + weighted;
      squares = squares + weighted * step;
      for (int c = 0; c < 3; ++c) {
        const Floats y = Floats::load(block.color[c] + i);
        color[c] = color[c] + weight * y;
        color_coverage[c] = color_coverage[c] + weighted * y;
      }
    }
  }
  result.ones = sum_of(ones);
  result.coverage = sum_of(coverage);
  result.squares = sum_of(squares);
  for (int c = 0; c < 3; ++c) {
    result.color[c] = sum_of(color[c]);
    result.color_coverage[c] = sum_of(color_coverage[c]);
  }
}

// The columns of a block: T' times the derivatives of q; residuals; 1 and T. All times the root of
// the weight.
constexpr int first_residual = parameters;
constexpr int first_known = first_residual + 3;

using Line = std::array<float, 3>;

ROBSIM_INLINE void fill(const EdgeBlock& block, const Shift& shift, const Line& level,
                        const Line& contrast, Columns& columns) {
  for (int i = 0; i < EdgeBlock::size; i += Floats::count) {
    const Floats root = Floats::load(block.weight + i);
    const Floats coverage = Floats::load(block.coverage + i);
    const Floats slope = root * Floats::load(block.slope + i);
    (slope * Floats::load(block.normal_x + i)).store(columns[0] + i);
    (slope * Floats::load(block.normal_y + i)).store(columns[1] + i);
    (slope * Floats::load(block.turn + i)).store(columns[2] + i);
    slope.store(columns[3] + i);
    (slope * shift.q(block, i)).store(columns[4] + i);
    for (int c = 0; c < 3; ++c) {
      const auto k = static_cast<std::size_t>(c);
      // r = y - level - contrast T
      const Floats line = Floats::all(level[k]) + Floats::all(contrast[k]) * coverage;
      (root * (Floats::load(block.color[c] + i) - line)).store(columns[first_residual + c] + i);
    }
    root.store(columns[first_known] + i);
    (root * coverage).store(columns[first_known + 1] + i);
  }
}

using Products = double[most_columns][most_columns];

ROBSIM_INLINE void multiply(const EdgePixels& pixels, const EdgeShift& edge_shift,
                            const Line& level, const Line& contrast, Products& products) {
  const Shift shift(pixels, edge_shift);
  Floats sums[most_columns][most_columns];
  for (auto& row : sums) {
    for (Floats& sum : row) sum = Floats::all(0);
  }
  alignas(32) Columns columns;
  for (const EdgeBlock& block : pixels.blocks) {
    fill(block, shift, level, contrast, columns);
    add_products<0, parameters, 0, most_columns>(columns, sums);
    add_products<first_residual, first_known, first_residual, first_known>(columns, sums);
    add_products<first_known, most_columns, first_known, most_columns>(columns, sums);
  }
  for (int i = 0; i < most_columns; ++i) {
    for (int j = i; j < most_columns; ++j) products[i][j] = sum_of(sums[i][j]);
  }
}

void cover_baseline(EdgePixels& pixels, const EdgeShift& shift, CoverSums& sums) {
  cover_all(pixels, shift, sums);
}

void multiply_baseline(const EdgePixels& pixels, const EdgeShift& shift, const Line& level,
                       const Line& contrast, Products& products) {
  multiply(pixels, shift, level, contrast, products);
}

#if ROBSIM_HAS_AVX2_CODE

ROBSIM_AVX2 void cover_avx2(EdgePixels& pixels, const EdgeShift& shift, CoverSums& sums) {
  cover_all(pixels, shift, sums);
}

ROBSIM_AVX2 void multiply_avx2(const EdgePixels& pixels, const EdgeShift& shift, const Line& level,
                               const Line& contrast, Products& products) {
  multiply(pixels, shift, level, contrast, products);
}

#endif

}  // namespace

bool cover(EdgePixels& pixels, const EdgeShift& shift, Appearance& appearance) {
  CoverSums sums;
  ROBSIM_PICK(cover_baseline, cover_avx2)(pixels, shift, sums);
  // The line y = level + contrast T with the least squares.
  const double determinant = sums.ones * sums.squares - sums.coverage * sums.coverage;
  if (!(determinant > 1e-3 * sums.ones * sums.ones)) return false;
  for (std::size_t c = 0; c < 3; ++c) {
    const double y = sums.color[c];
    const double yt = sums.color_coverage[c];
    appearance.contrast[c] = (sums.ones * yt - sums.coverage * y) / determinant;
    appearance.level[c] = (sums.squares * y - sums.coverage * yt) / determinant;
  }
  return true;
}

EdgeSums sums_of(const EdgePixels& pixels, const EdgeShift& shift, const Appearance& appearance) {
  Line level, contrast;
  for (std::size_t c = 0; c < 3; ++c) {
    level[c] = static_cast<float>(appearance.level[c]);
    contrast[c] = static_cast<float>(appearance.contrast[c]);
  }
  Products products;
  ROBSIM_PICK(multiply_baseline, multiply_avx2)(pixels, shift, level, contrast, products);
  EdgeSums sums;
  constexpr int one = first_known, t = first_known + 1;
  sums.count = products[one][one];
  sums.slope = products[3][3];
  const double determinant =
      products[one][one] * products[t][t] - products[one][t] * products[one][t];
  for (std::size_t i = 0; i < parameters; ++i) {
    for (std::size_t j = i; j < parameters; ++j) {
      // D'PD = D'D - D'K (K'K)^-1 K'D,  K = (1, T)
      const double known = (products[t][t] * products[i][one] * products[j][one] -
                            products[one][t] * (products[i][one] * products[j][t] +
                                                products[i][t] * products[j][one]) +
                            products[one][one] * products[i][t] * products[j][t]) /
                           determinant;
      sums.information[i][j] = sums.information[j][i] = products[i][j] - known;
    }
    for (std::size_t c = 0; c < 3; ++c) sums.gradient[i][c] = products[i][first_residual + c];
  }
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t d = c; d < 3; ++d) {
      sums.residuals[c][d] = sums.residuals[d][c] =
          products[first_residual + c][first_residual + d];
    }
  }
  return sums;
}

}  // namespace robsim::fit
