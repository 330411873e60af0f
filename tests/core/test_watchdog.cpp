// Who calls when nobody feeds it, and when not.
#include "robsim/lab/motors/safety.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <limits>
#include <stdexcept>
#include <thread>

#include "robsim/base/system.hpp"

namespace robsim {
namespace {

constexpr double soon = 0.01;     // s
constexpr double never = 1000.0;  // s, as far as a test goes

void sleep_for(double time) { sleep_until(monotonic_now() + time); }

struct Expiry {
  std::promise<double> at;
  std::atomic<int> calls{0};

  void operator()() {
    if (++calls == 1) at.set_value(monotonic_now());
  }
};

TEST(Watchdog, ExpiresOnceWhereNothingComes) {
  Expiry expiry;
  Watchdog watchdog([&] { expiry(); });
  const double start = monotonic_now();
  watchdog.arm(soon);
  EXPECT_GE(expiry.at.get_future().get(), start + soon);
  EXPECT_TRUE(watchdog.has_expired());
  sleep_for(3 * soon);
  watchdog.feed(monotonic_now());
  sleep_for(3 * soon);
  EXPECT_EQ(expiry.calls, 1);
  EXPECT_TRUE(watchdog.has_expired());
}

TEST(Watchdog, WatchesAgainWhenItIsArmedAgain) {
  std::atomic<int> calls{0};
  Watchdog watchdog([&] { ++calls; });
  for (int i = 1; i <= 3; ++i) {
    watchdog.arm(soon);
    while (!watchdog.has_expired()) sleep_for(soon);
    watchdog.disarm();
    EXPECT_EQ(calls, i);
  }
  watchdog.arm(never);
  EXPECT_FALSE(watchdog.has_expired());
}

TEST(Watchdog, WaitsOneTimeoutAfterTheLastArrival) {
  Expiry expiry;
  Watchdog watchdog([&] { expiry(); });
  watchdog.arm(5 * soon);
  double last = 0;
  for (int i = 0; i < 20 && !watchdog.has_expired(); ++i) {
    last = monotonic_now();
    watchdog.feed(last);
    sleep_for(soon);
  }
  watchdog.feed(last - 1);  // what is older moves nothing back
  EXPECT_GE(expiry.at.get_future().get(), last + 5 * soon);
}

TEST(Watchdog, TakesAnArrivalInTheFutureForOneOfNow) {
  Expiry expiry;
  Watchdog watchdog([&] { expiry(); });
  watchdog.arm(soon);
  watchdog.feed(monotonic_now() + never);
  watchdog.feed(std::numeric_limits<double>::infinity());
  const auto status = expiry.at.get_future().wait_for(std::chrono::minutes(5));
  EXPECT_EQ(status, std::future_status::ready);
}

TEST(Watchdog, IsNotDeceivedByATimeThatIsNone) {
  Expiry expiry;
  Watchdog watchdog([&] { expiry(); });
  watchdog.arm(soon);
  watchdog.feed(std::numeric_limits<double>::quiet_NaN());
  const auto status = expiry.at.get_future().wait_for(std::chrono::minutes(5));
  EXPECT_EQ(status, std::future_status::ready);
}

TEST(Watchdog, IsQuietWhereItIsNotArmed) {
  std::atomic<int> calls{0};
  Watchdog watchdog([&] { ++calls; });
  watchdog.disarm();
  watchdog.feed(monotonic_now());
  for (int i = 0; i < 50; ++i) {
    watchdog.arm(never);
    watchdog.disarm();
  }
  watchdog.arm(std::numeric_limits<double>::infinity());
  sleep_for(2 * soon);
  watchdog.disarm();
  EXPECT_EQ(calls, 0);
  EXPECT_FALSE(watchdog.has_expired());
}

TEST(Watchdog, DoesNotCallAfterItWasDisarmed) {
  for (int i = 0; i < 200; ++i) {
    std::atomic<bool> is_disarmed{false}, is_late{false};
    Watchdog watchdog([&] {
      std::this_thread::yield();
      is_late = is_late || is_disarmed;
    });
    watchdog.arm(1e-4);
    sleep_for(1e-6 * i);
    watchdog.disarm();
    is_disarmed = true;
    std::this_thread::yield();
    EXPECT_FALSE(is_late);
  }
}

TEST(Watchdog, MayBeCalledWhereItExpires) {
  std::atomic<int> calls{0};
  Watchdog* self = nullptr;
  Watchdog watchdog([&] {
    self->disarm();
    if (++calls == 1) self->arm(1e-3);
  });
  self = &watchdog;
  watchdog.arm(1e-3);
  while (calls < 2) sleep_for(1e-3);
  watchdog.disarm();
}

TEST(Watchdog, EndsWhileItWatches) {
  for (const double timeout : {1e-5, 1e-4, never}) {
    for (int i = 0; i < 50; ++i) {
      Watchdog watchdog([] {});
      watchdog.arm(timeout);
    }
  }
}

TEST(Watchdog, IsFedByOneThreadAndStoppedByOthers) {
  std::atomic<bool> is_over{false};
  Watchdog watchdog([] {});
  std::thread feeder([&] {
    while (!is_over) watchdog.feed(monotonic_now());
  });
  std::thread looker([&] {
    while (!is_over) static_cast<void>(watchdog.has_expired());
  });
  for (int i = 0; i < 200; ++i) {
    watchdog.arm(1e-3);
    watchdog.disarm();
  }
  is_over = true;
  feeder.join();
  looker.join();
}

TEST(Watchdog, RefusesATimeoutThatIsNone) {
  Watchdog watchdog([] {});
  for (const double timeout : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(watchdog.arm(timeout), std::invalid_argument);
  }
}

}  // namespace
}  // namespace robsim
