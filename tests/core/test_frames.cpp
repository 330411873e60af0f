// Frames of a camera: their times from late arrivals, and their pixels from a socket.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "robsim/lab/capture/frame_clock.hpp"
#include "robsim/lab/capture/pixel_stream.hpp"

namespace robsim {
namespace {

// --- times

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

// The part of the arrivals' jitter that is left in the times.
double jitter_left(FrameClock clock, std::uint32_t seed) {
  std::mt19937 random(seed);
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
  return jitter / jitter_of_arrivals;
}

// Of 200 starts: an interval that is measured wrong at first must not confirm itself.
TEST(FrameClock, TheJitterOfArrivalsIsDamped) {
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    EXPECT_LT(jitter_left(FrameClock(interval), seed), 0.25) << "seed " << seed;
    EXPECT_LT(jitter_left(FrameClock(), seed), 0.25) << "seed " << seed;
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

// --- pixels

// The end that the other process writes to, and the stream at this one.
class PixelStreamTest : public testing::Test {
 protected:
  PixelStreamTest() : ends_(connected()), stream_(ends_.second, "the camera") {
    ::close(ends_.second);
  }
  ~PixelStreamTest() override { end(); }

  void end() {
    if (ends_.first >= 0) ::close(ends_.first);
    ends_.first = -1;
  }

  void write(const void* bytes, std::size_t size) {
    ASSERT_EQ(::write(ends_.first, bytes, size), static_cast<ssize_t>(size));
  }

  void send(PixelStream::Kind kind, std::uint32_t width, std::uint32_t height,
            const std::string& body, double arrived = 0, double exposed = std::nan("")) {
    const auto length = static_cast<std::uint32_t>(body.size());
    const PixelStream::Head head{kind, width, height, length, 3, 2, arrived, exposed};
    write(&head, sizeof head);
    write(body.data(), body.size());
  }

  std::optional<Captured> next() { return stream_.next(pool_); }

  CaptureFault fault() {
    try {
      next();
    } catch (const CaptureError& error) {
      text_ = error.what();
      return error.fault();
    }
    ADD_FAILURE() << "nothing was thrown";
    return CaptureFault::failed;
  }

  std::string text_;

 private:
  static std::pair<int, int> connected() {
    int ends[2] = {-1, -1};
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    return {ends[0], ends[1]};
  }

  std::pair<int, int> ends_;
  PixelStream stream_;
  ImagePool pool_;
};

std::vector<int> pixels_of(const Captured& captured) {
  const std::uint8_t* row = captured.image.row(0);
  return {row, row + 3 * captured.image.width()};
}

TEST_F(PixelStreamTest, FramesComeWithTheirTimesAndWithWhatTheyPassed) {
  send(PixelStream::opened, 0, 0, "");
  send(PixelStream::bgr, 2, 1, "abcdef", 1.5);
  send(PixelStream::bgr, 2, 1, "abcdef", 2.5, 2.25);
  EXPECT_FALSE(next());
  const auto first = next();
  ASSERT_TRUE(first);
  EXPECT_EQ(pixels_of(*first), (std::vector<int>{'c', 'b', 'a', 'f', 'e', 'd'}));
  EXPECT_EQ(first->arrived, 1.5);
  EXPECT_FALSE(first->exposed);
  EXPECT_EQ(first->passed, 3);
  EXPECT_EQ(first->torn, 2);
  const auto second = next();
  ASSERT_TRUE(second);
  EXPECT_EQ(second->arrived, 2.5);
  EXPECT_EQ(second->exposed, 2.25);
}

TEST_F(PixelStreamTest, AFrameMayComeInPieces) {
  const PixelStream::Head head{PixelStream::bgr, 1, 1, 3, 0, 0, 0, 0};
  const auto* const bytes = reinterpret_cast<const char*>(&head);
  write(bytes, 5);
  EXPECT_FALSE(next());
  write(bytes + 5, sizeof head - 5);
  write("ab", 2);
  EXPECT_FALSE(next());
  write("c", 1);
  const auto frame = next();
  ASSERT_TRUE(frame);
  EXPECT_EQ(pixels_of(*frame), (std::vector<int>{'c', 'b', 'a'}));
}

TEST_F(PixelStreamTest, ATornFrameHasNoPixels) {
  send(PixelStream::nothing, 0, 0, "");
  const auto frame = next();
  ASSERT_TRUE(frame);
  EXPECT_FALSE(frame->is_complete);
}

TEST_F(PixelStreamTest, AFaultIsToldByItsName) {
  send(PixelStream::fault, 0, 0, "time_out\nnothing has come");
  EXPECT_EQ(fault(), CaptureFault::time_out);
  EXPECT_EQ(text_, "nothing has come");
  send(PixelStream::bgr, 1, 1, "abc");  // which may be tried again
  EXPECT_TRUE(next());
}

TEST_F(PixelStreamTest, TheEndOfTheOtherProcessIsThatOfTheCamera) {
  write("ab", 2);
  end();
  EXPECT_EQ(fault(), CaptureFault::unplugged);
}

TEST_F(PixelStreamTest, WhatDoesNotFitIsRefused) {
  send(PixelStream::bgr, 2, 2, "abc");
  EXPECT_EQ(fault(), CaptureFault::failed);
  const PixelStream::Head head{PixelStream::bgr, 1, 1, 0xffffffff, 0, 0, 0, 0};
  write(&head, sizeof head);
  EXPECT_EQ(fault(), CaptureFault::failed);
  EXPECT_NE(text_.find("too large"), std::string::npos);
}

}  // namespace
}  // namespace robsim
