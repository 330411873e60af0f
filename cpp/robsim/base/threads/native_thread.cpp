#include "robsim/base/threads/native_thread.hpp"

#ifdef _WIN32
#include <process.h>
#else
#include <pthread.h>
#include <signal.h>
#include <unistd.h>
#endif

namespace robsim {

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
