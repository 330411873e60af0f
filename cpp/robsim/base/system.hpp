// Functions of the operating system: numbers as text, the clock, threads.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

namespace robsim {

/// A number as messages show it: with ten digits that count, whatever its size.
std::string to_text(double value);

/// The value, unless it is not as expected: then throws std::invalid_argument, "margin must be at
/// least 0, got -1".
template <typename T>
T checked(T value, bool holds, const char* expected) {
  if (holds) return value;
  throw std::invalid_argument(expected + (", got " + to_text(static_cast<double>(value))));
}

/// Time of a clock that nobody sets, and that Python's time.monotonic() shows, too (s).
double monotonic_now();

/// Sleeps until this time of it (s).
void sleep_until(double time);

/// A thread that no signal comes to: Ctrl-C must wake the interpreter's own.
std::thread start_thread(std::function<void()> work);

/// Number of this process.
long long process_id();

/// What has a thread, and so belongs to one process. In a forked one its thread is not there, and
/// its locks may be held for ever: there it is never touched, nor destroyed.
template <typename T>
class OfProcess {
 public:
  /// `what` begins the refusal: "the watchdog".
  template <typename... A>
  explicit OfProcess(std::string what, A&&... arguments)
      : what_(std::move(what)), value_(std::make_unique<T>(std::forward<A>(arguments)...)) {}
  ~OfProcess() {
    if (!is_here()) static_cast<void>(value_.release());
  }
  OfProcess(const OfProcess&) = delete;
  OfProcess& operator=(const OfProcess&) = delete;

  bool is_here() const { return process_ == process_id(); }

  /// Throws std::runtime_error in a forked process.
  T* operator->() const {
    if (!is_here()) {
      throw std::runtime_error(what_ +
                               " was opened in another process, from which this one was forked: "
                               "open one of its own");
    }
    return value_.get();
  }

  /// A part of the object, read under its mutex. Throws in a forked process.
  template <typename Read>
  auto read(Read read) const {
    const T& value = *operator->();
    const std::lock_guard lock(value.mutex);
    return read(value);
  }

  /// Without that check.
  T& unchecked() const { return *value_; }

 private:
  std::string what_;
  std::unique_ptr<T> value_;
  long long process_ = process_id();
};

}  // namespace robsim
