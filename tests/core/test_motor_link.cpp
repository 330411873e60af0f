// A link and the robot's end of its line, over UDP on loopback and over a pair of descriptors.
#include "robsim/lab/motors/motor_link.hpp"

#include <gtest/gtest.h>

#ifndef _WIN32

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <limits>
#include <thread>

#include "robsim/base/system.hpp"
#include "robsim/lab/motors/motor_receiver.hpp"
#include "robsim/lab/motors/protocol.hpp"
#include "robsim/lab/motors/safety.hpp"

namespace robsim {
namespace {

constexpr double ttl = 0.06;   // s
constexpr double hold = 1000;  // s, as far as a test goes

void wait_until(const std::function<bool()>& is_so) {
  for (int i = 0; i < 300'000 && !is_so(); ++i) sleep_until(monotonic_now() + 1e-3);
  EXPECT_TRUE(is_so());
}

struct Pair {
  explicit Pair(double time_to_live = ttl)
      : link(Line::udp_to("127.0.0.1", robot.port()), time_to_live, hold) {}

  MotorReceiver robot{Line::udp_at("127.0.0.1", 0), 0, true};
  MotorLink link;

  void wait_for(double u1) {
    wait_until([&] { return robot.input().u1 == u1; });
  }
};

int count(const std::vector<MotorEvent>& events, MotorEvent::Kind kind) {
  return static_cast<int>(std::count_if(events.begin(), events.end(),
                                        [&](const MotorEvent& e) { return e.kind == kind; }));
}

TEST(MotorLink, KeepsTheRobotGoingBetweenInputs) {
  Pair pair;
  pair.link.send({0.5, -0.25});
  wait_until([&] { return count(pair.robot.events(), MotorEvent::Kind::input) > 6; });
  EXPECT_GT(count(pair.link.events(), MotorEvent::Kind::repeat), 5);
  EXPECT_FALSE(pair.link.round_trip_times().empty());
  pair.link.stop();
  pair.wait_for(0);
  EXPECT_EQ(pair.robot.events().back().kind, MotorEvent::Kind::stop);
}

TEST(MotorLink, StopsTheRobotWhereNoInputFollows) {
  MotorReceiver robot(Line::udp_at("127.0.0.1", 0), 0, true);
  MotorLink link(Line::udp_to("127.0.0.1", robot.port()), ttl, 0.1);
  const double sent = link.send({1, 1});
  wait_until([&] { return count(link.events(), MotorEvent::Kind::stop) >= 5; });
  for (const MotorEvent& event : link.events()) {
    EXPECT_TRUE(event.kind != MotorEvent::Kind::stop || event.t >= sent + 0.1);
  }
  link.send({2, 2});
  wait_until([&] {
    const auto events = robot.events();
    return std::any_of(events.begin(), events.end(),
                       [](const MotorEvent& e) { return e.u.u1 == 2; });
  });
}

TEST(MotorLink, IsStoppedByAWatchdogAndRefusesInputs) {
  Pair pair;
  Watchdog watchdog([&] { pair.link.halt(); });
  pair.link.send({1, 1});
  watchdog.arm(0.05);
  wait_until([&] { return watchdog.has_expired() && pair.link.is_halted(); });
  EXPECT_THROW(pair.link.send({1, 1}), HaltedError);
  pair.wait_for(0);
  pair.link.resume();
  pair.link.send({3, 3});
  pair.wait_for(3);
  pair.link.close();
  EXPECT_THROW(pair.link.send({1, 1}), LineError);
}

TEST(MotorLink, TellsOfALineThatNobodyListensTo) {
  auto robot = std::make_unique<MotorReceiver>(Line::udp_at("127.0.0.1", 0), 0, true);
  MotorLink link(Line::udp_to("127.0.0.1", robot->port()), ttl, hold);
  link.send({1, 1});
  robot.reset();
  std::string told;
  wait_until([&] {
    try {
      link.send({1, 1});
    } catch (const LineError& error) {
      told = error.what();
    }
    return !told.empty();
  });
  EXPECT_NE(told.find("refused"), std::string::npos);
  wait_until([&] { return count(link.events(), MotorEvent::Kind::stop) >= 2; });
}

TEST(MotorLink, ServesSeveralThreads) {
  Pair pair;
  std::atomic<bool> is_over{false};
  const auto again = [&](auto call) {
    return std::thread([&is_over, call] {
      while (!is_over) call();
    });
  };
  std::thread threads[] = {
      again([&] {
        try {
          pair.link.send({1, 2});
        } catch (const HaltedError&) {
        }
      }),
      again([&] { pair.link.stop(); }),
      again([&] { pair.link.halt(), pair.link.resume(); }),
      again([&] { sleep_until(monotonic_now() + 1e-3), pair.robot.mean(0, monotonic_now()); }),
      again([&] { sleep_until(monotonic_now() + 1e-3), pair.link.events(), pair.robot.events(); }),
  };
  sleep_until(monotonic_now() + 0.2);
  is_over = true;
  for (std::thread& thread : threads) thread.join();
  std::thread other([&] { pair.link.close(); });
  pair.link.close();
  other.join();
  pair.wait_for(0);
}

TEST(MotorLink, GoesOnAfterALineThatWasBrokenOff) {
  int ends[2];
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  Line line = Line::of_descriptor(ends[0], "a full line");
  std::size_t written = 0;
  const std::string text = to_line({Command::Kind::input, 7, {1, 2}, 300});
  EXPECT_THROW(
      while (true) {
        line.write(text, 0);
        written += text.size();
      },
      LineError);
  LineReader reader;
  std::string all;
  const auto take = [&] {
    char bytes[4096];
    for (ssize_t n; (n = recv(ends[1], bytes, sizeof(bytes), MSG_DONTWAIT)) > 0;) {
      all.append(bytes, static_cast<std::size_t>(n));
    }
  };
  take();
  line.write(text, 0);
  take();
  const auto lines = reader.read(all);
  EXPECT_TRUE(parse_line(lines.back()));
  EXPECT_GE(lines.size(), written / text.size() + 1);
  for (const int end : ends) ::close(end);
}

TEST(MotorReceiver, TakesTheExactMeanOfWhatItReceived) {
  Pair pair(60);  // s: it never runs out between two repeats
  pair.link.send({1, 3});
  pair.wait_for(1);
  pair.link.send({2, -1});
  pair.wait_for(2);
  pair.link.stop();
  pair.wait_for(0);
  std::vector<double> times;
  for (const MotorEvent& event : pair.robot.events()) {
    const double u1 = times.size() < 2 ? static_cast<double>(times.size() + 1) : 0;
    if (times.size() < 3 && event.u.u1 == u1) times.push_back(event.t);
  }
  ASSERT_EQ(times.size(), 3u);
  const double from = times[0] - 0.5, to = times[2] + 0.5;
  const Input mean = pair.robot.mean(from, to);
  EXPECT_NEAR(mean.u1, (times[1] - times[0] + 2 * (times[2] - times[1])) / (to - from), 1e-9);
  EXPECT_NEAR(mean.u2, (3 * (times[1] - times[0]) - (times[2] - times[1])) / (to - from), 1e-9);
  EXPECT_EQ(pair.robot.mean(times[0], times[0]).u1, 1);
  EXPECT_EQ(pair.robot.mean(times[2] + 1, times[2] + 2).u1, 0);
}

TEST(MotorReceiver, ActsLaterByTheDelay) {
  MotorReceiver robot(Line::udp_at("127.0.0.1", 0), 100, true);
  MotorLink link(Line::udp_to("127.0.0.1", robot.port()), ttl, hold);
  link.send({1, 1});
  wait_until([&] { return !robot.events().empty(); });
  const double heard = robot.events().front().t;
  EXPECT_EQ(robot.input().u1, 0);
  EXPECT_EQ(robot.mean(heard + 100, heard + 100).u1, 1);
  EXPECT_EQ(robot.mean(heard + 99, heard + 99).u1, 0);
}

TEST(MotorLink, RefusesTimesThatAreNone) {
  const auto link = [](double time_to_live, double hold_time) {
    MotorLink(Line::udp_to("127.0.0.1", 9), time_to_live, hold_time);
  };
  EXPECT_THROW(link(0.01, 1), std::invalid_argument);
  EXPECT_THROW(link(61, 1), std::invalid_argument);
  EXPECT_THROW(link(std::numeric_limits<double>::quiet_NaN(), 1), std::invalid_argument);
  EXPECT_THROW(link(0.3, 0), std::invalid_argument);
  EXPECT_THROW(link(0.3, std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
}

}  // namespace
}  // namespace robsim

#endif
