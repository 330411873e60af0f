#include "robsim/lab/motors/motor_link.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "robsim/base/system.hpp"
#include "robsim/lab/motors/protocol.hpp"

namespace robsim {

namespace {

constexpr double never = std::numeric_limits<double>::infinity();
constexpr double write_time = 0.05;      // s, most for a line
constexpr int quick_stops = 5;           // in a row, since a line may be lost
constexpr double quick_interval = 0.02;  // s, between them
constexpr double stop_time = 2;          // s, for which it is told to stop
constexpr std::size_t most_round_trips = 1000;
constexpr double silence = 1;  // s without an answer

}  // namespace

struct MotorLink::State {
  State(Line opened, double time_to_live, double hold);

  void check_open() const;
  double send(const Input& input);
  void close();

  void run();
  void go_on();
  void listen();
  double write(Command::Kind kind, MotorEvent::Kind event);
  void begin_stop();
  void tell_to_stop();
  void schedule(double time);
  void throw_error(std::optional<std::string>& error);
  bool is_over() const { return is_closing && (mode == Mode::idle || n_stops >= quick_stops); }

  enum class Mode { idle, driving, stopping };

  const double time_to_live, hold;  // s
  const Line::Wake wake;
  std::mutex closing;
  std::thread thread;

  mutable std::mutex mutex;  // guards what follows; the thread alone waits for the line, without it
  Line line;
  LineReader reader;
  Mode mode = Mode::idle;
  bool is_halted = false, is_closing = false;
  Input u;
  double hold_until = 0;
  int n_stops = 0;  // since the last input
  double stop_until = 0;
  double next = never;      // when the thread writes again
  double asleep_until = 0;  // when it looks at `next`
  std::uint16_t number = 0;
  // Still to be thrown: of an input, of a repeated stop, of the last stop in a call.
  std::optional<std::string> error, stop_error, last_stop_error;
  std::array<double, 64> written_at{};  // the newest lines, by number
  std::deque<double> round_trips;
  std::optional<double> unanswered_since;
  bool is_silent = false;
  EventLog log;
};

MotorLink::State::State(Line opened, double time_to_live, double hold)
    : time_to_live(time_to_live), hold(hold), line(std::move(opened)) {
  thread = start_thread([this] { run(); });
}

void MotorLink::State::run() {
  std::unique_lock lock(mutex);
  while (!is_over()) {
    if (monotonic_now() >= next) {
      go_on();
      continue;
    }
    asleep_until = next;
    const double left = next - monotonic_now();
    lock.unlock();
    line.wait(wake, left);
    lock.lock();
    listen();
  }
}

void MotorLink::State::go_on() {
  const double now = monotonic_now();
  if (mode == Mode::stopping) return tell_to_stop();
  if (now >= hold_until) return begin_stop();
  try {
    write(Command::Kind::input, MotorEvent::Kind::repeat);
    schedule(std::min(now + time_to_live / 3, hold_until));
  } catch (const LineError& failure) {
    error = failure.what();
    begin_stop();
  }
}

// Answers, and what the system knows of the line.
void MotorLink::State::listen() {
  try {
    while (const auto piece = line.read()) {
      const double now = monotonic_now();
      for (const std::string& text : reader.read(piece->bytes)) {
        const auto answer = parse_line(text);
        if (!answer || answer->kind != Command::Kind::answer) continue;
        const auto age = static_cast<std::uint16_t>(number - 1 - answer->number);
        if (age >= written_at.size()) continue;
        if (round_trips.size() == most_round_trips) round_trips.pop_front();
        round_trips.push_back(now - written_at[answer->number % written_at.size()]);
        unanswered_since.reset();
        is_silent = false;
      }
    }
  } catch (const LineError& failure) {
    (mode == Mode::driving ? error : stop_error) = failure.what();
    if (mode == Mode::driving) begin_stop();
  }
}

double MotorLink::State::write(Command::Kind kind, MotorEvent::Kind event) {
  const Input sent = kind == Command::Kind::stop ? Input{} : u;
  const int milliseconds = static_cast<int>(std::lround(1000 * time_to_live));
  const std::string text = to_line({kind, number, sent, milliseconds});
  written_at[number++ % written_at.size()] = monotonic_now();
  try {
    line.write(text, write_time);
  } catch (const LineError&) {
    log.add({monotonic_now(), sent, MotorEvent::Kind::failure});
    throw;
  }
  const double now = monotonic_now();
  log.add({now, sent, event});
  if (!unanswered_since) unanswered_since = now;
  if (!is_silent && !round_trips.empty() && now - *unanswered_since > silence) {
    is_silent = true;
    log.add({now, sent, MotorEvent::Kind::silence});
  }
  return now;
}

void MotorLink::State::begin_stop() {
  mode = Mode::stopping;
  stop_error.reset();
  n_stops = 0;
  stop_until = monotonic_now() + stop_time;
  tell_to_stop();
}

void MotorLink::State::tell_to_stop() {
  try {
    write(Command::Kind::stop, MotorEvent::Kind::stop);
  } catch (const LineError& failure) {
    stop_error = failure.what();
  }
  const double now = monotonic_now();
  if (++n_stops < quick_stops) {
    schedule(now + quick_interval);
  } else if (now < stop_until) {
    schedule(now + time_to_live / 3);
  } else {
    mode = Mode::idle;
    unanswered_since.reset();  // nothing is asked
    is_silent = false;
    schedule(never);
  }
}

void MotorLink::State::schedule(double time) {
  next = time;
  if (next < asleep_until) wake.ring();
}

void MotorLink::State::throw_error(std::optional<std::string>& error) {
  if (error) throw LineError(*std::exchange(error, std::nullopt));
}

double MotorLink::State::send(const Input& input) {
  const Input rounded = as_written(input);
  const std::lock_guard lock(mutex);
  if (is_closing) throw LineError(line.name() + " was closed: open it anew");
  if (is_halted) {
    throw HaltedError("the robot at " + line.name() +
                      " was halted: it takes no input before resume()");
  }
  throw_error(error);
  u = rounded;
  try {
    const double now = write(Command::Kind::input, MotorEvent::Kind::input);
    mode = Mode::driving;
    hold_until = now + hold;
    schedule(std::min(now + time_to_live / 3, hold_until));
    return now;
  } catch (const LineError&) {
    begin_stop();  // nobody knows what has arrived
    error.reset();
    throw;
  }
}

void MotorLink::State::close() {
  const std::lock_guard one(closing);
  if (!thread.joinable()) return;
  {
    const std::lock_guard lock(mutex);
    if (mode == Mode::driving) begin_stop();
    is_closing = true;
  }
  wake.ring();
  thread.join();
  line.close();
  throw_error(error);
  throw_error(stop_error);
  throw_error(last_stop_error);
}

MotorLink::MotorLink(Line line, double time_to_live, double hold)
    : name_(line.name()),
      time_to_live_(time_to_live),
      hold_(hold),
      state_("the line " + line.name(), std::move(line),
             checked(time_to_live, time_to_live >= 0.03 && time_to_live <= 60,
                     "ttl must lie within 0.03..60 s"),
             checked(hold, hold > 0, "hold must be above 0 s")) {}

MotorLink::~MotorLink() {
  if (!state_.is_here()) return;
  try {
    state_->close();
  } catch (const std::exception&) {  // nobody is left to be told
  }
}

double MotorLink::send(const Input& u) { return state_->send(u); }

double MotorLink::stop() {
  state_.operator->();
  stop_quietly();
  check_stop();
  return monotonic_now();
}

bool MotorLink::stop_quietly() noexcept {
  if (!state_.is_here()) return false;
  State& state = state_.unchecked();
  const std::lock_guard lock(state.mutex);
  if (state.is_closing) return true;
  state.begin_stop();
  if (state.stop_error) state.begin_stop();  // it may have come from an earlier line
  state.last_stop_error = std::exchange(state.stop_error, std::nullopt);
  return true;
}

void MotorLink::check_stop() {
  if (!state_.is_here()) return;
  State& state = state_.unchecked();
  const std::lock_guard lock(state.mutex);
  state.throw_error(state.last_stop_error);
}

void MotorLink::halt() noexcept {
  if (!state_.is_here()) return;
  {
    const std::lock_guard lock(state_.unchecked().mutex);
    state_.unchecked().is_halted = true;
  }
  stop_quietly();
}

void MotorLink::resume() {
  State& state = *state_.operator->();
  const std::lock_guard lock(state.mutex);
  state.is_halted = false;
}

void MotorLink::close() { state_->close(); }

bool MotorLink::is_halted() const {
  return state_.is_here() && state_.read([](const State& s) { return s.is_halted; });
}

bool MotorLink::is_closed() const {
  return !state_.is_here() || state_.read([](const State& s) { return s.is_closing; });
}

std::vector<MotorEvent> MotorLink::events() const {
  return state_.read([](const State& s) { return s.log.get(); });
}

bool MotorLink::is_silent() const {
  return state_.read([](const State& s) { return s.is_silent; });
}

std::vector<double> MotorLink::round_trip_times() const {
  return state_.read([](const State& s) {
    return std::vector<double>(s.round_trips.begin(), s.round_trips.end());
  });
}

}  // namespace robsim
