#include "robsim/lab/motors/motor_receiver.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <limits>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "robsim/base/system.hpp"
#include "robsim/lab/motors/protocol.hpp"

namespace robsim {

namespace {

constexpr double at_no_time = std::numeric_limits<double>::infinity();
constexpr double pause = 0.01;  // s, before it looks again whether the other end is back
constexpr std::size_t most_pieces = 100'000;

}  // namespace

struct MotorReceiver::State {
  // An input and the times between which it was received.
  struct Held {
    double from, until;
    Input u;
  };

  State(Line opened, bool answers);
  ~State();

  void run();
  void listen();
  void hear(const Line::Piece& piece);
  void obey(const Command& command, const std::string& sender, double now);
  void hold(const Input& u, double now, double until);
  void note_timeout();
  void answer(const Command& command);
  Input mean(double from, double to) const;

  const Line::Wake wake;
  const bool answers;
  std::mutex closing;
  std::thread thread;

  mutable std::mutex mutex;  // guards what follows; the thread alone waits for the line, without it
  Line line;
  LineReader reader;
  bool is_closing = false;
  std::uint16_t number = 0;          // of the newest line
  std::string source;                // that it came from
  double heard_until = 0;            // as long as that sender is taken to be there
  double drives_until = at_no_time;  // at_no_time: it stands
  std::deque<Held> held;
  EventLog log;
  LineCounts counts;
};

MotorReceiver::State::State(Line opened, bool answers) : answers(answers), line(std::move(opened)) {
  thread = start_thread([this] { run(); });
}

MotorReceiver::State::~State() {
  {
    const std::lock_guard lock(mutex);
    is_closing = true;
  }
  wake.ring();
  if (thread.joinable()) thread.join();
}

void MotorReceiver::State::run() {
  std::unique_lock lock(mutex);
  double look_again = at_no_time;
  while (!is_closing) {
    const double next = std::min(drives_until, look_again);
    lock.unlock();
    line.wait(wake, next - monotonic_now());
    lock.lock();
    note_timeout();
    if (monotonic_now() >= look_again) line.read_again();
    look_again = at_no_time;
    try {
      listen();
    } catch (const LineError&) {
      look_again = monotonic_now() + pause;
    }
  }
}

void MotorReceiver::State::listen() {
  while (const auto piece = line.read()) hear(*piece);
}

void MotorReceiver::State::hear(const Line::Piece& piece) {
  const double now = monotonic_now();
  if (piece.is_whole) reader.clear();
  for (const std::string& text : reader.read(piece.bytes)) {
    const auto command = parse_line(text);
    if (!command || command->kind == Command::Kind::answer) {
      ++counts.damaged;
    } else {
      obey(*command, piece.source, now);
    }
  }
}

void MotorReceiver::State::obey(const Command& command, const std::string& sender, double now) {
  note_timeout();
  const bool hears_one = now < heard_until;
  if (hears_one && sender != source) {
    ++counts.foreign;
    return;
  }
  if (hears_one && !is_newer(command.number, number)) {
    ++counts.old;
    return;
  }
  ++counts.valid;
  number = command.number;
  source = sender;
  heard_until = now + command.time_to_live / 1000.0;
  const bool is_stop = command.kind == Command::Kind::stop;
  hold(command.u, now, is_stop ? now : heard_until);
  drives_until = is_stop ? at_no_time : heard_until;
  log.add({now, command.u, is_stop ? MotorEvent::Kind::stop : MotorEvent::Kind::input});
  answer(command);
}

void MotorReceiver::State::hold(const Input& u, double now, double until) {
  if (!held.empty()) held.back().until = std::min(held.back().until, now);
  if (until <= now) return;
  const bool goes_on = !held.empty() && held.back().until == now && held.back().u.u1 == u.u1 &&
                       held.back().u.u2 == u.u2;
  if (goes_on) {
    held.back().until = until;
    return;
  }
  if (held.size() == most_pieces) held.pop_front();
  held.push_back({now, until, u});
}

void MotorReceiver::State::note_timeout() {
  if (monotonic_now() < drives_until) return;
  log.add({drives_until, {}, MotorEvent::Kind::timeout});
  drives_until = at_no_time;
}

void MotorReceiver::State::answer(const Command& command) {
  if (!answers) return;
  try {
    line.write(to_line({Command::Kind::answer, command.number, {}, 0}), 0);
  } catch (const LineError&) {  // it is for the sender alone
  }
}

// 1 / (to - from) * integral of u(t) dt, piecewise constant.
Input MotorReceiver::State::mean(double from, double to) const {
  const double duration = to - from;
  Input sum;
  for (auto piece = held.rbegin(); piece != held.rend() && piece->until > from; ++piece) {
    if (piece->from > to) continue;
    if (piece->from <= from && (piece->until >= to || duration <= 0)) return piece->u;
    const double time = std::min(to, piece->until) - std::max(from, piece->from);
    sum.u1 += piece->u.u1 * time;
    sum.u2 += piece->u.u2 * time;
  }
  if (duration <= 0) return {};
  return {sum.u1 / duration, sum.u2 / duration};
}

MotorReceiver::MotorReceiver(Line line, double actuation_delay, bool answers)
    : name_(line.name()),
      port_(line.port()),
      actuation_delay_(checked(actuation_delay,
                               actuation_delay >= 0 && std::isfinite(actuation_delay),
                               "actuation_delay must be finite and at least 0 s")),
      state_("the receiver at " + line.name(), std::move(line), answers) {}

MotorReceiver::~MotorReceiver() = default;

Input MotorReceiver::mean(double from, double to) const {
  return state_.read(
      [&](const State& s) { return s.mean(from - actuation_delay_, to - actuation_delay_); });
}

Input MotorReceiver::input() const {
  const double now = monotonic_now();
  return mean(now, now);
}

std::vector<MotorEvent> MotorReceiver::events() const {
  return state_.read([](const State& s) { return s.log.get(); });
}

LineCounts MotorReceiver::counts() const {
  return state_.read([](const State& s) { return s.counts; });
}

void MotorReceiver::close() {
  State& state = *state_.operator->();
  const std::lock_guard one(state.closing);
  if (!state.thread.joinable()) return;
  {
    const std::lock_guard lock(state.mutex);
    state.is_closing = true;
  }
  state.wake.ring();
  state.thread.join();
  state.line.close();
}

bool MotorReceiver::is_closed() const {
  return !state_.is_here() || state_.read([](const State& s) { return s.is_closing; });
}

}  // namespace robsim
