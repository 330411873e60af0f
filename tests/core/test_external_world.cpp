// A world outside: how long a frame is waited for, and a run that needs no interpreter.
#include "robsim/simulation/world/external_world.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

#include "robsim/base/system.hpp"
#include "robsim/simulation/loop.hpp"

namespace robsim {
namespace {

using namespace std::chrono_literals;

constexpr double patience = 300;  // s

FrameSource nothing() {
  return {[](std::int64_t, Arrived&) { return Arrival::nothing_yet; }};
}

// Frames without end, of a camera that needs no interpreter.
FrameSource endless() {
  const auto take = [](std::int64_t, Arrived& arrived) {
    std::this_thread::sleep_for(1ms);
    arrived.frame.emplace();
    arrived.frame->epoch = 0;
    arrived.frame->t = monotonic_now();
    return Arrival::step;
  };
  return {take, true, false};
}

Arrival next(ExternalWorld& world, std::int64_t k) {
  Observation observation;
  return world.next(k, observation);
}

std::unique_ptr<Loop> loop_of(const InputSink& inputs) {
  auto loop = std::make_unique<Loop>(std::make_shared<ExternalWorld>(endless(), inputs, patience),
                                     RobotOptions{}, IdentifyFrom::truth);
  loop->stages().define_model = default_model;
  loop->stages().init_parameter_estimator = default_parameter_estimator;
  return loop;
}

TEST(ExternalWorld, AFrameThatDoesNotComeInTimeIsAnError) {
  ExternalWorld world(nothing(), {}, 0.05);
  EXPECT_THROW(while (true) next(world, 1), FrameTimeout);
}

TEST(ExternalWorld, TheFirstFrameMayComeTenTimesAsLate) {
  ExternalWorld world(nothing(), {}, patience);
  EXPECT_EQ(next(world, 0), Arrival::nothing_yet);
  ExternalWorld impatient(nothing(), {}, 0.005);
  const double begin = monotonic_now();
  EXPECT_THROW(while (true) next(impatient, 0), FrameTimeout);
  EXPECT_GE(monotonic_now() - begin, 0.05);
}

TEST(ExternalWorld, AWaitThatWasStoppedDoesNotCountForTheNextRun) {
  ExternalWorld world(nothing(), {}, 0.05);
  bool goes_on = false;  // on a busy machine not at once
  for (int attempt = 0; attempt < 1000 && !goes_on; ++attempt) {
    try {
      next(world, 1);
      std::this_thread::sleep_for(60ms);
      world.stop();
      next(world, 1);
      goes_on = true;
    } catch (const FrameTimeout&) {
      world.stop();
    }
  }
  EXPECT_TRUE(goes_on);
}

TEST(ExternalWorld, ARunGoesOnWhileItsLookUpWaits) {
  const auto loop = loop_of({});
  std::int64_t seen = 0;
  const auto wait = [&](std::int64_t) {
    const double end = monotonic_now() + patience;
    const std::int64_t before = loop->trace().rows();
    while (loop->trace().rows() < before + 10 && monotonic_now() < end) std::this_thread::yield();
    seen = loop->trace().rows() - before;
    loop->stop();
  };
  EXPECT_FALSE(loop->run(1'000'000, wait, true));
  EXPECT_GE(seen, 10);
}

TEST(ExternalWorld, WhatALookUpThrowsEndsTheRunAndStopsTheRobot) {
  std::atomic<int> n_stops{0};
  InputSink inputs;
  inputs.send = [](std::int64_t, const Input&) { return std::optional<double>(); };
  inputs.stop = [&] { return ++n_stops, Input{}; };
  inputs.is_interpreted = false;
  const auto loop = loop_of(inputs);
  const auto fail = [](std::int64_t) { throw std::domain_error("of the test"); };
  EXPECT_THROW(loop->run(1'000'000, fail, true), std::domain_error);
  EXPECT_EQ(n_stops, 1);
  EXPECT_FALSE(loop->guard().is_running());
  EXPECT_FALSE(loop->run(3, [](std::int64_t) {}, true));  // the next run is like the first
  EXPECT_EQ(n_stops, 2);
}

}  // namespace
}  // namespace robsim
