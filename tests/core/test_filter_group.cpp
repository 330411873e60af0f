// The lanes of a filter group against the textbook's recursive least squares, one filter at a time.
#include "robsim/estimation/filter_group.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <limits>
#include <random>
#include <vector>

#include "robsim/base/simd/cpu_path.hpp"

namespace robsim {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double initial_covariance = 100;

// Ljung, System Identification, 2nd ed., section 11.2
struct PlainFilter {
  VectorXd theta;
  MatrixXd P;
  double forgetting;

  PlainFilter(int n, double lambda)
      : theta(VectorXd::Zero(n)),
        P(MatrixXd::Identity(n, n) * initial_covariance),
        forgetting(lambda) {}

  void update(const VectorXd& phi, double y) {
    // K = P phi/(lambda + phi' P phi),  theta <- theta + K (y - phi' theta),
    // P <- (P - K phi' P)/lambda
    const VectorXd K = P * phi / (forgetting + phi.dot(P * phi));
    theta += K * (y - phi.dot(theta));
    P = (P - K * (phi.transpose() * P)).eval() / forgetting;
  }
};

MatrixXd covariance_of(const FilterGroup& group, int filter, int n) {
  MatrixXd U = MatrixXd::Identity(n, n);
  VectorXd D(n);
  for (int j = 0; j < n; ++j) {
    D[j] = group.d(filter, j);
    for (int i = 0; i < j; ++i) U(i, j) = group.u(filter, i, j);
  }
  return U * D.asDiagonal() * U.transpose();
}

struct Samples {
  std::vector<double> phi, y;
  int count;
};

Samples random_samples(int n, int filters, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Samples samples{{}, {}, count};
  for (int i = 0; i < count * filters * n; ++i) samples.phi.push_back(normal(random));
  for (int i = 0; i < count * filters; ++i) samples.y.push_back(normal(random));
  return samples;
}

void update(FilterGroup& group, const Samples& samples) {
  group.update(
      {samples.phi.data(), samples.y.data(), nullptr, samples.count, group.filters(), true});
}

void expect_plain(const FilterGroup& group, const Samples& samples, int n, double forgetting) {
  std::vector<double> estimates(static_cast<std::size_t>(group.filters() * n));
  std::vector<double> errors(estimates.size());
  group.write_estimates(estimates.data());
  group.write_standard_errors_unscaled(errors.data());
  for (int filter = 0; filter < group.filters(); ++filter) {
    PlainFilter plain(n, forgetting);
    int used = 0;
    for (int k = 0; k < samples.count; ++k) {
      const int row = k * group.filters() + filter;
      const VectorXd phi = Eigen::Map<const VectorXd>(samples.phi.data() + row * n, n);
      const double y = samples.y[static_cast<std::size_t>(row)];
      if (phi.hasNaN() || y != y) continue;
      plain.update(phi, y);
      ++used;
    }
    const Eigen::Map<const VectorXd> theta(estimates.data() + filter * n, n);
    const Eigen::Map<const VectorXd> error(errors.data() + filter * n, n);
    EXPECT_LT((theta - plain.theta).norm(), 1e-9) << "filter " << filter;
    EXPECT_LT((covariance_of(group, filter, n) - plain.P).norm(), 1e-9) << "filter " << filter;
    EXPECT_LT((error - plain.P.diagonal().cwiseSqrt()).norm(), 1e-9) << "filter " << filter;
    EXPECT_EQ(group.samples(filter), used) << "filter " << filter;
  }
}

// Parameters, filters: five parameters take a path of their own.
class FilterGroupOf : public testing::TestWithParam<std::tuple<simd::CpuPath, int, int>> {
 protected:
  void SetUp() override { simd::force_cpu_path(std::get<0>(GetParam())); }
  void TearDown() override { simd::force_cpu_path(simd::cpu_paths().back()); }

  const int n = std::get<1>(GetParam());
  const int filters = std::get<2>(GetParam());
};

TEST_P(FilterGroupOf, EveryLaneIsAPlainFilter) {
  for (const double forgetting : {1.0, 0.97}) {
    SCOPED_TRACE("forgetting " + std::to_string(forgetting));
    FilterGroup group(n, filters, forgetting, initial_covariance);
    const Samples samples = random_samples(n, filters, 60, 1);
    update(group, samples);
    expect_plain(group, samples, n, forgetting);
  }
}

TEST_P(FilterGroupOf, ALaneWithNanSkipsTheUpdateAndTheOthersDoNot) {
  Samples samples = random_samples(n, filters, 60, 2);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int k = 0; k < samples.count; k += 3) {
    const int filter = k % filters;
    const auto row = static_cast<std::size_t>(k * filters + filter);
    if (k % 2 == 0) {
      samples.y[row] = nan;
    } else {
      samples.phi[row * static_cast<std::size_t>(n)] = nan;
    }
  }
  FilterGroup group(n, filters, 0.99, initial_covariance);
  update(group, samples);
  expect_plain(group, samples, n, 0.99);
}

TEST_P(FilterGroupOf, WithoutExcitationTheTraceStaysBelowItsLimit) {
  FilterGroup group(n, filters, 0.5, initial_covariance);
  Samples samples = random_samples(n, filters, 300, 3);
  std::fill(samples.phi.begin(), samples.phi.end(), 0.0);
  update(group, samples);
  for (int filter = 0; filter < filters; ++filter) {
    EXPECT_NEAR(covariance_of(group, filter, n).trace(), group.covariance_limit(),
                1e-6 * group.covariance_limit());
  }
}

INSTANTIATE_TEST_SUITE_P(PathsAndSizes, FilterGroupOf,
                         testing::Combine(testing::ValuesIn(simd::cpu_paths()),
                                          testing::Values(2, 5, 7), testing::Values(1, 3, 4)));

}  // namespace
}  // namespace robsim
