// When frames were exposed, from arrivals that are late by chance.
#include "robsim/lab/capture/frame_clock.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace robsim {
namespace {

constexpr double interval = 1.0 / 30;

Captured arrived_at(double time) {
  Captured captured;
  captured.arrived = time;
  return captured;
}

TEST(FrameClock, AnExposureThatTheDeviceKnowsIsTheTime) {
  FrameClock clock;
  Captured captured = arrived_at(10);
  captured.exposed = 9.97;
  EXPECT_EQ(clock.time_of(captured), 9.97);
}

TEST(FrameClock, TheLeastDelayIsTakenForTheOffsetOfTheDevicesClock) {
  FrameClock clock;
  std::mt19937 random(1);
  std::exponential_distribution<double> late(200);  // 5 ms
  double worst = 0;
  for (int i = 0; i < 600; ++i) {
    Captured captured = arrived_at(1000 + i * interval + 0.003 + late(random));
    captured.device_time = 7 + i * interval;
    const double time = clock.time_of(captured);
    EXPECT_LE(time, captured.arrived);
    if (i > 100) worst = std::max(worst, std::abs(time - (1000.003 + i * interval)));
  }
  EXPECT_LT(worst, 0.0015);
}

TEST(FrameClock, TheJitterOfArrivalsIsDamped) {
  for (const bool is_known : {true, false}) {
    FrameClock clock(is_known ? std::optional<double>(interval) : std::nullopt);
    std::mt19937 random(2);
    std::normal_distribution<double> late(0.010, 0.003);
    double before = 0, jitter = 0, jitter_of_arrivals = 0, arrival_before = 0;
    for (int i = 0; i < 600; ++i) {
      const double arrival = 50 + i * interval + std::max(0.0, late(random));
      const double time = clock.time_of(arrived_at(arrival));
      EXPECT_LE(time, arrival);
      if (i > 200) {
        jitter += std::pow(time - before - interval, 2);
        jitter_of_arrivals += std::pow(arrival - arrival_before - interval, 2);
      }
      before = time;
      arrival_before = arrival;
    }
    EXPECT_LT(jitter, jitter_of_arrivals / 4);
  }
}

TEST(FrameClock, LostFramesAreWholeIntervals) {
  FrameClock clock(interval);
  double last = 0;
  for (int i = 0; i < 100; ++i) last = clock.time_of(arrived_at(i * interval));
  for (const int lost : {1, 3, 40}) {
    const double time = clock.time_of(arrived_at(last + (lost + 1) * interval + 0.002));
    EXPECT_NEAR(time - last, (lost + 1) * interval, 0.0005);
    last = time;
  }
}

TEST(FrameClock, AWrongRateIsFoundAndABurstAtTheStartForgotten) {
  FrameClock clock(1.0 / 25);
  for (int i = 0; i < 8; ++i) clock.time_of(arrived_at(i * 1e-4));
  double time = 0, arrival = 0;
  for (int i = 1; i < 400; ++i) {
    arrival = i / 60.0;
    time = clock.time_of(arrived_at(arrival));
  }
  EXPECT_NEAR(time, arrival, 1e-3);
  EXPECT_NEAR(clock.time_of(arrived_at(arrival + 1 / 60.0 + 0.004)) - time, 1 / 60.0, 1.5e-3);
}

TEST(FrameClock, TimesIncreaseWhateverComes) {
  FrameClock clock;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(0, 0.1);
  double arrival = 0, last = -1;
  for (int i = 0; i < 2000; ++i) {
    Captured captured = arrived_at(arrival += i % 3 ? any(random) : 0);
    if (i % 5 == 0) captured.device_time = any(random);
    if (i % 11 == 0) captured.exposed = arrival - any(random);
    if (i % 17 == 0) clock.restart();
    const double time = clock.time_of(captured);
    EXPECT_GT(time, last);
    last = time;
  }
}

}  // namespace
}  // namespace robsim
