#include "robsim/base/timing/monotonic.hpp"

#include <chrono>
#include <thread>

namespace robsim {

namespace {
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;
}  // namespace

double monotonic_now() { return Seconds(Clock::now().time_since_epoch()).count(); }

void sleep_until(double time) {
  const auto left = std::chrono::duration_cast<Clock::duration>(Seconds(time - monotonic_now()));
  std::this_thread::sleep_for(left);
}

}  // namespace robsim
