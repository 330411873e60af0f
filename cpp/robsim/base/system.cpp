#include "robsim/base/system.hpp"

#include <chrono>
#include <iomanip>
#include <locale>
#include <sstream>
#include <thread>

#ifdef _WIN32
#include <process.h>
#else
#include <pthread.h>
#include <signal.h>
#include <unistd.h>
#endif

namespace robsim {

std::string to_text(double value) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::setprecision(10) << value;
  return text.str();
}

namespace {
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;
}  // namespace

double monotonic_now() { return Seconds(Clock::now().time_since_epoch()).count(); }

void sleep_until(double time) {
  const auto left = std::chrono::duration_cast<Clock::duration>(Seconds(time - monotonic_now()));
  std::this_thread::sleep_for(left);
}

#ifdef _WIN32

std::thread start_thread(std::function<void()> work) { return std::thread(std::move(work)); }

long long process_id() { return _getpid(); }

#else

std::thread start_thread(std::function<void()> work) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);  // a new thread inherits it
  try {
    std::thread thread(std::move(work));
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    return thread;
  } catch (...) {
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    throw;
  }
}

long long process_id() { return getpid(); }

#endif

}  // namespace robsim
