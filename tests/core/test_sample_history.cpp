// Samples of the last three poses: what interrupts them, and which times are refused.
#include "robsim/simulation/sample_history.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <vector>

namespace robsim {
namespace {

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
    samples.push_back(step.sample);
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
  EXPECT_FALSE(step.sample);
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

}  // namespace
}  // namespace robsim
