// Who has an object that changes, with threads that are made to meet.
#include "robsim/simulation/seam/thread_guard.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <future>
#include <stdexcept>
#include <string>
#include <thread>

namespace robsim {
namespace {

std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

template <typename Claim>
void expect_to_wait_for_a_look() {
  const ThreadGuard guard("in use", "lost");
  std::promise<void> looks;
  bool has_looked = false;
  std::thread other([&] {
    const ThreadGuard::Look look(guard);
    looks.set_value();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    has_looked = true;
  });
  looks.get_future().wait();
  {
    const Claim claim(guard);
    EXPECT_TRUE(has_looked);
  }
  other.join();
}

TEST(ThreadGuard, ALookWaitsForThatOfAnotherThread) {
  expect_to_wait_for_a_look<ThreadGuard::Look>();
}

TEST(ThreadGuard, ARunWaitsForTheLookOfAnotherThread) {
  expect_to_wait_for_a_look<ThreadGuard::Run>();
}

TEST(ThreadGuard, AnotherThreadIsRefusedDuringARunAndNotAfterIt) {
  const ThreadGuard guard("in use", "lost");
  const auto look = [&] { const ThreadGuard::Look claim(guard); };
  const auto elsewhere = [](const std::function<void()>& call) {
    return std::async(std::launch::async, [&] { return refusal(call); }).get();
  };
  {
    const ThreadGuard::Run run(guard);
    EXPECT_EQ(elsewhere(look), "in use");
    EXPECT_EQ(elsewhere([&] { guard.check_thread(); }), "in use");
    EXPECT_EQ(refusal(look), "");
    EXPECT_TRUE(guard.is_in_run());
    EXPECT_EQ(elsewhere(look), "in use") << "the look has given back the run";
  }
  EXPECT_EQ(elsewhere(look), "");
  EXPECT_FALSE(guard.is_in_run());
}

TEST(RunGuard, IsAskedToStopOnceOrTwiceButNotWhenIdle) {
  RunGuard guard;
  EXPECT_FALSE(guard.stop());
  {
    const RunGuard::Run run(guard);
    EXPECT_TRUE(guard.stop());
    EXPECT_TRUE(guard.stop());
    EXPECT_TRUE(guard.is_stopped());
  }
  EXPECT_FALSE(guard.is_stopped());
}

}  // namespace
}  // namespace robsim
