// Samples of the last three poses, and filter groups against plain recursive least squares.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <stdexcept>
#include <vector>

#include "robsim/base/simd/cpu_path.hpp"
#include "robsim/estimation/filter_group.hpp"
#include "robsim/simulation/sample_history.hpp"

namespace robsim {
namespace {

// --- samples

const RobotModel model;
const double dt = model.dt();

// What a step of a run has; the poses and inputs are all different.
struct Row {
  double dt = robsim::dt;  // s
  bool is_seen = true;
  bool bounced = false;
  bool is_interrupted = false;
  std::optional<Input> last_u = {};
};

Pose pose_of(std::int64_t k) {
  const auto x = static_cast<double>(k);
  return {x * x, 3 * x + 1, 0.1 * x};
}

Input input_of(std::int64_t k) { return {std::sin(static_cast<double>(k)), 0.5}; }

// The samples that steps give, in the order of the steps.
std::vector<std::optional<Sample>> samples_from(IdentifyFrom identify_from,
                                                const std::vector<Row>& rows) {
  SampleHistory history(identify_from);
  Step step(std::make_shared<RunGuard>(), nullptr);
  std::vector<std::optional<Sample>> samples;
  for (const Row& row : rows) {
    step.begin(nullptr);
    step.k = static_cast<std::int64_t>(samples.size());
    step.dt = row.dt;
    Truth truth;
    truth.pose = pose_of(step.k);
    truth.bounced = row.bounced;
    history.begin(step, model, row.last_u, row.is_interrupted, false);
    history.write_newest(step, &truth);
    samples.push_back(step.find_sample());
    if (row.is_seen) step.measurement = Measurement{pose_of(step.k)};
    step.u = input_of(step.k);
    history.add(step, &truth);
  }
  return samples;
}

std::set<std::int64_t> steps_of(const std::vector<std::optional<Sample>>& samples) {
  std::set<std::int64_t> steps;
  for (const auto& sample : samples) {
    if (sample) steps.insert(sample->k);
  }
  return steps;
}

std::vector<Row> changed(std::size_t k, const Row& row) {
  std::vector<Row> rows(8);
  rows[k] = row;
  return rows;
}

using Steps = std::set<std::int64_t>;

TEST(SampleHistory, ASampleNeedsThreePoses) {
  const auto measured = samples_from(IdentifyFrom::measurement, std::vector<Row>(6));
  EXPECT_EQ(steps_of(measured), (Steps{2, 3, 4}));
  const auto exact = samples_from(IdentifyFrom::truth, std::vector<Row>(6));
  EXPECT_EQ(steps_of(exact), (Steps{2, 3, 4, 5}));
  const Regression expected = regression(pose_of(3), pose_of(2), pose_of(1), input_of(2));
  EXPECT_EQ(measured[4]->regression.phi, expected.phi);
  EXPECT_EQ(measured[4]->regression.y, expected.y);
  EXPECT_EQ(exact[3]->regression.phi, expected.phi);
}

TEST(SampleHistory, APoseThatIsMissingCostsTheThreeSamplesThatNeedIt) {
  EXPECT_EQ(steps_of(samples_from(IdentifyFrom::measurement, changed(3, {dt, false}))),
            (Steps{2, 6}));
}

TEST(SampleHistory, WhatDoesNotFollowFromTheStepBeforeCostsTwo) {
  const std::vector<Row> breaks = {
      {2 * dt}, {5 * dt}, {dt, true, true}, {dt, true, false, true}, {2 * dt, true, true, true}};
  for (const Row& row : breaks) {
    EXPECT_EQ(steps_of(samples_from(IdentifyFrom::measurement, changed(3, row))), (Steps{2, 5, 6}));
    EXPECT_EQ(steps_of(samples_from(IdentifyFrom::truth, changed(3, row))), (Steps{2, 5, 6, 7}));
  }
}

TEST(SampleHistory, TheInputThatTheRobotReallyGotCounts) {
  Row row;
  row.last_u = Input{7, 8};
  for (const IdentifyFrom source : {IdentifyFrom::measurement, IdentifyFrom::truth}) {
    const auto samples = samples_from(source, changed(4, row));
    const std::size_t k = source == IdentifyFrom::truth ? 4 : 5;
    const Regression expected = regression(pose_of(4), pose_of(3), pose_of(2), {7, 8});
    EXPECT_EQ(samples[k]->regression.phi, expected.phi);
    const Regression next = regression(pose_of(5), pose_of(4), pose_of(3), input_of(4));
    EXPECT_EQ(samples[k + 1]->regression.phi, next.phi);
  }
}

TEST(SampleHistory, NobodyKnowsTheTruthOutside) {
  Step step(std::make_shared<RunGuard>(), nullptr);
  SampleHistory(IdentifyFrom::truth).write_newest(step, nullptr);
  EXPECT_FALSE(step.has_sample());
}

// The step at which times are refused, -1 = never.
std::int64_t refused_at(const std::vector<double>& intervals, bool is_interrupted = false,
                        bool is_live = false) {
  SampleHistory history(IdentifyFrom::measurement);
  Step step(std::make_shared<RunGuard>(), nullptr);
  for (const double interval : intervals) {
    step.dt = interval;
    history.begin(step, model, {}, is_interrupted, is_live);
    try {
      history.check_interval(step, model);
    } catch (const std::invalid_argument&) {
      return step.k;
    }
    ++step.k;
  }
  return -1;
}

TEST(SampleHistory, OnlyTimesOfTheModelAreAccepted) {
  EXPECT_EQ(refused_at({dt, dt, 0.033}), 2);
  EXPECT_EQ(refused_at({dt, 0.4 * dt}), 1);
  EXPECT_EQ(refused_at({dt, 1.5 * dt}), 1);
  EXPECT_EQ(refused_at({dt, 1.2 * dt, 0.8 * dt, 2 * dt, 9 * dt}), -1);
}

TEST(SampleHistory, LiveFramesOutOfTheirTurnAreRefusedIfTheyGoOn) {
  EXPECT_EQ(refused_at({dt, 1.4 * dt, 0.6 * dt, dt, 0.4 * dt, dt}, false, true), -1);
  EXPECT_EQ(refused_at(std::vector<double>(30, 0.4 * dt), false, true), 9);
}

TEST(SampleHistory, TimesThatAreWrongOnAverageAreRefusedAfterTenSteps) {
  EXPECT_EQ(refused_at(std::vector<double>(30, 0.8 * dt)), 10);
  EXPECT_EQ(refused_at(std::vector<double>(30, 1.06 * dt)), 10);
  EXPECT_EQ(refused_at(std::vector<double>(30, 1.04 * dt)), -1);
  std::vector<double> jitter;
  for (int i = 0; i < 40; ++i) jitter.push_back(dt * (i % 2 ? 1.2 : 0.8));
  EXPECT_EQ(refused_at(jitter), -1);
}

TEST(SampleHistory, AnInterruptionHasNoTime) {
  EXPECT_EQ(refused_at(std::vector<double>(30, 0.8 * dt), true), -1);
}

// --- filter groups

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
