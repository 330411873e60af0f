// The distributions that the noise tables stand for, summed up exactly from the tables.
#include "robsim/world/visual_noise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace robsim {
namespace {

// P(node), from the columns of the alias table: each is drawn with 1/16, its threshold against one
// of 256 signed bytes.
std::vector<double> node_weights(const GaussianTables& tables) {
  std::vector<double> weights(16, 0.0);
  for (std::size_t column = 0; column < 16; ++column) {
    const double own = (tables.threshold[column] + 128) / 256.0;
    weights[column] += own / 16;
    weights[tables.alias[column]] += (1 - own) / 16;
  }
  return weights;
}

// P(step before the sign = k) at index k + 512
std::vector<double> step_distribution(const GaussianTables& tables) {
  std::vector<double> probability(1024, 0.0);
  const std::vector<double> weights = node_weights(tables);
  for (std::size_t i = 0; i < 16; ++i) {
    if (tables.mask[i] == GaussianTables::tail_mark) continue;
    const int count = tables.mask[i] + 1;
    for (int u1 = 0; u1 < count; ++u1) {
      for (int u2 = 0; u2 < count; ++u2) {
        const int step = tables.node[i] + u1 - u2;
        probability[static_cast<std::size_t>(step + 512)] += weights[i] / (count * count);
      }
    }
  }
  double beyond = 1;  // P(|step| > k - 1) in the tail
  for (int k = tables.tail_first; k <= 255; ++k) {
    const double next = tables.beyond[static_cast<std::size_t>(k)] / std::pow(2.0, 32);
    probability[static_cast<std::size_t>(512 + k)] += weights[15] * (beyond - next) / 2;
    probability[static_cast<std::size_t>(512 - k)] += weights[15] * (beyond - next) / 2;
    beyond = next;
  }
  return probability;
}

class GaussianTablesOf : public testing::TestWithParam<double> {};

TEST_P(GaussianTablesOf, TheWeightsOfTheNodesSumToOne) {
  double sum = 0;
  for (const double weight : node_weights(gaussian_tables(GetParam()))) sum += weight;
  EXPECT_NEAR(sum, 1, 1e-12);
}

TEST_P(GaussianTablesOf, EveryColumnIsFullyDistributed) {
  const GaussianTables tables = gaussian_tables(GetParam());
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_LT(tables.alias[i], 16) << i;
    if (i == 15) continue;
    EXPECT_EQ(tables.mask[i] & (tables.mask[i] + 1), 0) << "mask " << i << " must be 2^k - 1";
  }
  EXPECT_EQ(tables.mask[15], GaussianTables::tail_mark);
}

TEST_P(GaussianTablesOf, TheStandardDeviationIsWhatWasAskedFor) {
  double variance = 0;
  const std::vector<double> probability = step_distribution(gaussian_tables(GetParam()));
  for (std::size_t i = 0; i < probability.size(); ++i) {
    variance += probability[i] * std::pow(static_cast<double>(i) - 512, 2);
  }
  // Rounding to whole steps adds 1/12; the tables are accurate to about 1 %.
  EXPECT_NEAR(std::sqrt(variance), std::sqrt(GetParam() * GetParam() + 1.0 / 12),
              0.015 * GetParam());
}

TEST_P(GaussianTablesOf, TheCumulativeDistributionIsThatOfAGaussian) {
  const std::vector<double> probability = step_distribution(gaussian_tables(GetParam()));
  double within = 0;  // P(|step| <= k)
  for (int k = 0; k <= 254; ++k) {
    within += probability[static_cast<std::size_t>(512 + k)];
    if (k > 0) within += probability[static_cast<std::size_t>(512 - k)];
    EXPECT_NEAR(within, std::erf((k + 0.5) / (GetParam() * std::sqrt(2.0))), 0.004) << k;
  }
}

TEST_P(GaussianTablesOf, TheTailIsTrueToSixStandardDeviations) {
  const std::vector<double> probability = step_distribution(gaussian_tables(GetParam()));
  double outside = 0;  // P(|step| > k)
  for (int k = 254; k >= 4 * GetParam(); --k) {
    outside += probability[static_cast<std::size_t>(513 + k)];
    outside += probability[static_cast<std::size_t>(511 - k)];
    const double expected = std::erfc((k + 0.5) / (GetParam() * std::sqrt(2.0)));
    if (k <= 6 * GetParam()) {
      EXPECT_NEAR(outside / expected, 1, 0.01) << k;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Deviations, GaussianTablesOf, testing::Values(2.55, 10.2, 25.5, 60.0));

// All 2^16 draws of the uniform noise.
std::vector<int> uniform_draws(const UniformSteps& steps) {
  std::vector<int> draws;
  for (std::uint32_t bits = 0; bits < 65536; ++bits) {
    const int drawn = static_cast<int>((bits * steps.scale) >> 16) + steps.offset;
    draws.push_back((drawn >> steps.shift) * (1 << steps.doublings));
  }
  return draws;
}

class UniformStepsOf : public testing::TestWithParam<double> {};

TEST_P(UniformStepsOf, TheDrawsAreSymmetric) {
  double sum = 0;
  for (const int draw : uniform_draws(uniform_steps(GetParam()))) sum += draw;
  EXPECT_NEAR(sum / 65536, 0, 0.001 * GetParam());
}

TEST_P(UniformStepsOf, TheDrawsReachTheHalfWidthAndNoFurther) {
  int maximum = 0;
  for (const int draw : uniform_draws(uniform_steps(GetParam()))) {
    maximum = std::max(maximum, std::abs(draw));
  }
  EXPECT_NEAR(maximum, GetParam(), 0.5);
}

TEST_P(UniformStepsOf, TheVarianceIsThatOfAUniformDistribution) {
  double squares = 0;
  for (const int draw : uniform_draws(uniform_steps(GetParam()))) squares += double(draw) * draw;
  const double expected = GetParam() * GetParam() / 3;
  EXPECT_NEAR(squares / 65536, expected, 0.01 * expected + 1.0 / 12);
}

INSTANTIATE_TEST_SUITE_P(HalfWidths, UniformStepsOf,
                         testing::Values(2.55, 25.5, 102.0, 255.0, 40000.0));

}  // namespace
}  // namespace robsim
