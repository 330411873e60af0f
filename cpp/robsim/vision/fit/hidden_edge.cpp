#include "robsim/vision/fit/hidden_edge.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <utility>
#include <vector>

#include "robsim/base/elementary/elementary.hpp"
#include "robsim/base/geometry.hpp"

namespace robsim::fit {

namespace {

constexpr double least_cosine = 0.6;  // between a direction and the normals at its ends

// Pixels are counted by the direction of their normals. The middle of the first is (0, -1).
constexpr std::size_t sectors = 32;

std::size_t sector_of(float x, float y) {
  const float size = std::fabs(x) + std::fabs(y);
  const float quarters = x >= 0 ? 1 + y / size : 3 - y / size;  // 0 to 4 around the circle
  return static_cast<std::size_t>(quarters * (sectors / 4) + 0.5F) % sectors;
}

Direction middle_of(std::size_t sector) {
  const double quarters = static_cast<double>(sector) * 4 / sectors;
  const double y = quarters <= 2 ? quarters - 1 : 3 - quarters;
  const double x = quarters <= 2 ? 1 - std::fabs(y) : std::fabs(y) - 1;
  const double length = std::sqrt(x * x + y * y);
  return {x / length, y / length};
}

// The sectors of a direction, and their shares.
using Shares = std::vector<std::pair<std::size_t, double>>;

std::array<Shares, hidden_directions> shares_of_directions() {
  std::array<Shares, hidden_directions> all;
  for (std::size_t i = 0; i < hidden_directions; ++i) {
    for (std::size_t k = 0; k < sectors; ++k) {
      const Direction middle = middle_of(k);
      const double share = hidden_share(directions_of_hidden_edges()[i], middle.x, middle.y);
      if (share > 0) all[i].emplace_back(k, share);
    }
  }
  return all;
}

const Shares& shares_of(std::size_t direction) {
  static const std::array<Shares, hidden_directions> all = shares_of_directions();
  return all[direction];
}

}  // namespace

const std::array<Direction, hidden_directions>& directions_of_hidden_edges() {
  static const auto all = [] {
    std::array<Direction, hidden_directions> directions;
    for (std::size_t i = 0; i < hidden_directions; ++i) {
      const auto [sin, cos] =
          elementary::sin_cos(2 * pi * static_cast<double>(i) / hidden_directions);
      directions[i] = {cos, sin};
    }
    return directions;
  }();
  return all;
}

double hidden_share(const Direction& direction, double normal_x, double normal_y) {
  const double cosine = direction.x * normal_x + direction.y * normal_y;
  return std::max(0.0, (cosine - least_cosine) / (1 - least_cosine));
}

EdgeSectors::EdgeSectors(const EdgeFit& part) : part_(part) {
  static_assert(std::tuple_size_v<decltype(sectors_)> == sectors);
  const std::vector<float> z = part.residuals();
  for (std::size_t i = 0; i < static_cast<std::size_t>(part.pixels.count); ++i) {
    const EdgeBlock& block = part.pixels.blocks[i / EdgeBlock::size];
    const std::size_t k = i % EdgeBlock::size;
    const float x = block.normal_x[k], y = block.normal_y[k];
    if (!(block.slope[k] > 0) || (x == 0 && y == 0)) continue;
    Sums& sums = sectors_[sector_of(x, y)];
    const float slope = block.weight[k] * block.weight[k] * block.slope[k];
    const float square = slope * block.slope[k];
    sums.residual += slope * z[i];
    sums.slope += slope;
    sums.slope_coverage += slope * block.coverage[k];
    sums.products[0] += square * x;
    sums.products[1] += square * y;
    sums.products[2] += square * block.turn[k];
    sums.products[3] += square;
  }
}

HiddenEdgeSums EdgeSectors::first_look(std::size_t direction) const {
  HiddenEdgeSums sums;
  for (const auto& [k, share] : shares_of(direction)) {
    sums.score += share * static_cast<double>(sectors_[k].residual);
    sums.squares += share * share * static_cast<double>(sectors_[k].products[3]);
  }
  return sums;
}

HiddenEdgeSums EdgeSectors::sums(std::size_t direction) const {
  HiddenEdgeSums sums = first_look(direction);
  double slope = 0, slope_coverage = 0;
  for (const auto& [k, share] : shares_of(direction)) {
    const Sums& sector = sectors_[k];
    slope += share * static_cast<double>(sector.slope);
    slope_coverage += share * static_cast<double>(sector.slope_coverage);
    for (std::size_t j = 0; j < 4; ++j)
      sums.cross[j] += share * static_cast<double>(sector.products[j]);
  }
  const Appearance& appearance = part_.appearance;
  const double ones = appearance.ones, t = appearance.coverage,
               squares = appearance.coverage_squares;
  const double determinant = ones * squares - t * t;
  // (K'K)^-1 K'H,  K = (1, T)
  const double of_ones = (squares * slope - t * slope_coverage) / determinant;
  const double of_t = (ones * slope_coverage - t * slope) / determinant;
  sums.information = sums.squares - of_ones * slope - of_t * slope_coverage;
  for (std::size_t j = 0; j < 4; ++j) {
    const auto& [in_ones, in_t] = part_.sums.appearance[j];
    sums.cross[j] -= of_ones * in_ones + of_t * in_t;
  }
  return sums;
}

}  // namespace robsim::fit
