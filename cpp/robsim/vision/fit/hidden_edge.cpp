#include "robsim/vision/fit/hidden_edge.hpp"

#include <Eigen/Dense>
#include <algorithm>

#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/base/simd/lanes.hpp"
#include "robsim/base/simd/target.hpp"

namespace robsim::fit {

namespace {

constexpr std::size_t axes = hidden_directions / 2;
constexpr float half_root = 0.70710678F;
constexpr float along[axes][2] = {{1, 0}, {half_root, half_root}, {0, 1}, {-half_root, half_root}};

using simd::HalvedLanesOf;
using simd::LanesOf;
using Scores = std::array<double, hidden_directions>;

// How much of an edge is moved: c^2 (1 + c)/2, with the cosine c between normal and direction.
float share_of(std::size_t direction, const EdgeBlock& block, int i) {
  const float* axis = along[direction % axes];
  const float c = axis[0] * block.normal_x[i] + axis[1] * block.normal_y[i];
  return c * c * (direction < axes ? 1 + c : 1 - c) / 2;
}
constexpr float least_left_out = 0.3F;

template <typename Floats>
ROBSIM_INLINE void score(const EdgeFit& part, Scores& scores) {
  const auto all = [](double value) { return Floats::all(static_cast<float>(value)); };
  const ChannelWeights& weights = part.weights;
  Floats squares[axes], cubes[axes];  // z c^2, z c^3
  std::fill_n(squares, axes, all(0));
  std::fill_n(cubes, axes, all(0));
  for (const EdgeBlock& block : part.pixels.blocks) {
    for (int i = 0; i < EdgeBlock::size; i += Floats::count) {
      Floats z =
          all(0) - all(weights.constant) - all(weights.gain) * Floats::load(block.coverage + i);
      for (std::size_t c = 0; c < 3; ++c)
        z = z + all(weights.of[c]) * Floats::load(block.color[c] + i);
      const Floats root = Floats::load(block.weight + i);
      z = root * root * Floats::load(block.slope + i) * z;
      const Floats x = Floats::load(block.normal_x + i), y = Floats::load(block.normal_y + i);
      for (std::size_t k = 0; k < axes; ++k) {
        const Floats c = all(along[k][0]) * x + all(along[k][1]) * y;
        const Floats square = z * c * c;
        squares[k] = squares[k] + square;
        cubes[k] = cubes[k] + square * c;
      }
    }
  }
  for (std::size_t k = 0; k < axes; ++k) {
    scores[k] = (sum_of(squares[k]) + sum_of(cubes[k])) / 2;
    scores[k + axes] = (sum_of(squares[k]) - sum_of(cubes[k])) / 2;
  }
}

}  // namespace

Scores scores_of_hidden_edges(const EdgeFit& part) {
  Scores scores;
  ROBSIM_PICK(score<HalvedLanesOf<float>>, score<LanesOf<float>>)(part, scores);
  return scores;
}

HiddenEdgeSums sums_of_hidden_edge(const EdgeFit& part, std::size_t direction) {
  // Of the columns T' (normal_x, normal_y, turn, 1), 1, T and H
  Eigen::Matrix<double, 7, 7> products = Eigen::Matrix<double, 7, 7>::Zero();
  for (const EdgeBlock& block : part.pixels.blocks) {
    for (int i = 0; i < EdgeBlock::size; ++i) {
      const double slope = static_cast<double>(block.slope[i]);
      if (slope == 0) continue;
      Eigen::Matrix<double, 7, 1> columns;
      columns << slope * static_cast<double>(block.normal_x[i]),
          slope * static_cast<double>(block.normal_y[i]),
          slope * static_cast<double>(block.turn[i]), slope, 1,
          static_cast<double>(block.coverage[i]),
          slope * static_cast<double>(share_of(direction, block, i));
      columns *= static_cast<double>(block.weight[i]);
      products += columns * columns.transpose();
    }
  }
  const double squares = products(6, 6);
  const Eigen::Matrix<double, 7, 2> known = products.middleCols<2>(4);
  const Appearance& sums_of_known = part.appearance;
  Eigen::Matrix2d squares_of_known;
  squares_of_known << sums_of_known.ones, sums_of_known.coverage,  //
      sums_of_known.coverage, sums_of_known.coverage_squares;
  products -= known * squares_of_known.inverse() * known.transpose();
  HiddenEdgeSums sums{squares, products(6, 6), {}};
  for (int j = 0; j < 4; ++j) sums.cross[static_cast<std::size_t>(j)] = products(j, 6);
  return sums;
}

void leave_out(std::size_t direction, EdgePixels& pixels) {
  for (EdgeBlock& block : pixels.blocks) {
    for (int i = 0; i < EdgeBlock::size; ++i) {
      if (share_of(direction, block, i) > least_left_out) block.weight[i] = 0;
    }
  }
}

}  // namespace robsim::fit
