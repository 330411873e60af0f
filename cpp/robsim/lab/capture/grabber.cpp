#include "robsim/lab/capture/grabber.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include "robsim/base/system.hpp"
#include "robsim/lab/capture/frame_clock.hpp"

namespace robsim {

namespace {

constexpr int timeouts_before_reopening = 3;
constexpr double shortest_call = 1e-3;  // s; a device should wait for a frame longer than this
constexpr double longest_wait = 1e6;    // s; a condition variable overflows at more
constexpr std::size_t watched = 30;     // times between frames
constexpr double alike = 0.8;           // of these, share

using Lock = std::unique_lock<std::mutex>;
using Seconds = std::chrono::duration<double>;

// What can be over after some time.
bool is_passing(CaptureFault fault) {
  return fault != CaptureFault::end && fault != CaptureFault::failed &&
         fault != CaptureFault::no_back_end;
}

}  // namespace

// Shared with the thread, which may outlive the grabber in a device that hangs.
struct Grabber::State {
  State(std::shared_ptr<CaptureDevice> camera, const GrabberOptions& chosen)
      : device(std::move(camera)), options(chosen), size(chosen.size), clock(chosen.interval) {}

  const std::shared_ptr<CaptureDevice> device;
  const GrabberOptions options;
  const long long process = process_id();

  mutable std::mutex mutex;
  mutable std::condition_variable changed;
  // Of both threads, under the mutex:
  std::optional<Frame> newest, taken;
  std::optional<std::pair<int, int>> seen;  // size of the first frame
  std::exception_ptr error;                 // that ended the camera
  CaptureCounts counts;
  std::optional<std::pair<double, double>> kept_rate;
  bool stops = false;
  bool has_ended = false;

  // Of the grabbing thread:
  std::optional<std::pair<int, int>> size;
  FrameClock clock;
  std::optional<double> epoch, last_t;
  PlaneMap plane_map;
  std::int64_t n_captured = 0;
  std::vector<double> intervals;  // between frames, s
  ImagePool pool;

  bool is_stopping() const {
    const Lock lock(mutex);
    return stops;
  }

  // True if it was stopped meanwhile.
  bool pause(double seconds) {
    Lock lock(mutex);
    return changed.wait_for(lock, Seconds(seconds), [&] { return stops; });
  }

  template <typename Condition>
  bool wait(Lock& lock, double timeout, const Condition& condition) const {
    return changed.wait_for(lock, Seconds(std::clamp(timeout, 0.0, longest_wait)),
                            [&] { return condition() || error || stops; });
  }

  // What a reader is told who gets no frame.
  void check() const {
    if (stops) throw std::invalid_argument("the camera is closed: open it anew");
    if (error) std::rethrow_exception(error);
  }

  void check_size(const Image& image);
  Frame frame_of(const Captured& captured);
  std::optional<double> watch_rate(const Frame& frame, std::int64_t count);
  void receive(const Captured& captured);
  void grab_until_fault();
  bool open_again();
  void run();
};

void Grabber::State::check_size(const Image& image) {
  const std::pair<int, int> got(image.width(), image.height());
  if (size && got != *size) {
    throw CaptureError(CaptureFault::failed, "the camera's frames have " +
                                                 size_text(got.first, got.second) + " instead of " +
                                                 size_text(size->first, size->second) +
                                                 ": open it again with the size that it has");
  }
  if (epoch) return;
  size = got;
  if (options.plane_map) {
    plane_map = *options.plane_map;
  } else if (options.area && *options.area != got) {
    plane_map = PlaneMap::scaled(got.first, got.second, options.area->first, options.area->second);
  }
}

Frame Grabber::State::frame_of(const Captured& captured) {
  check_size(captured.image);
  const double time = clock.time_of(captured);
  if (!epoch) epoch = time;
  Frame frame;
  frame.image = captured.image;
  frame.t = time - *epoch;
  frame.t_arrival = captured.arrived - *epoch;
  frame.epoch = *epoch;
  frame.index = n_captured;
  frame.plane_map = plane_map;
  frame.headings = options.headings;
  return frame;
}

// Of a frame that comes `count` images after the last one: the rate, if it has turned out to be a
// fraction of the promised one.
std::optional<double> Grabber::State::watch_rate(const Frame& frame, std::int64_t count) {
  const std::optional<double> before = std::exchange(last_t, frame.t);
  if (!options.interval || !before) return {};
  intervals.push_back((*frame.t - *before) / static_cast<double>(count));
  if (intervals.size() < watched) return {};
  std::nth_element(intervals.begin(), intervals.begin() + watched / 2, intervals.end());
  const double middle = intervals[watched / 2];
  const double multiple = std::round(middle / *options.interval);
  const auto same = std::count_if(intervals.begin(), intervals.end(), [&](double one) {
    return std::round(one / *options.interval) == multiple;
  });
  intervals.clear();
  const bool is_fraction = multiple >= 2 && static_cast<double>(same) > alike * watched;
  return is_fraction ? std::optional(1 / middle) : std::nullopt;
}

void Grabber::State::receive(const Captured& captured) {
  std::optional<Frame> frame;
  std::optional<double> rate;
  n_captured += captured.passed + captured.torn;
  if (captured.is_complete) {
    frame = frame_of(captured);
    rate = watch_rate(*frame, captured.passed + captured.torn + 1);
  }
  ++n_captured;
  const Lock lock(mutex);
  if (rate && !kept_rate) kept_rate = {*rate, 1 / *options.interval};
  counts.torn += captured.torn;
  if (!frame) {
    ++counts.torn;
    return;
  }
  seen = size;
  // Each n-th counts, whether it is this one or one that it has passed.
  const std::int64_t before = (counts.grabbed + options.every - 1) / options.every;
  counts.grabbed += captured.passed + 1;
  const std::int64_t due = (counts.grabbed + options.every - 1) / options.every - before;
  if (due > 0) {
    counts.dropped += due - 1 + newest.has_value();
    newest = std::move(frame);
  }
  changed.notify_all();
}

// Until it is told to stop, or a CaptureError.
void Grabber::State::grab_until_fault() {
  double since = monotonic_now();
  int timeouts = 0;
  while (!is_stopping()) {
    std::optional<Captured> captured;
    bool is_timeout = false;
    const double before = monotonic_now();
    try {
      captured = device->next(pool);
    } catch (const CaptureError& fault) {
      if (fault.fault() != CaptureFault::time_out) throw;
      is_timeout = true;
    }
    const double now = monotonic_now();
    if (!captured && now - before < shortest_call) pause(shortest_call);
    if (captured) {
      receive(*captured);
      if (captured->is_complete) {
        since = now;
        timeouts = 0;
      }
    }
    if (!is_timeout && now - since < options.frame_timeout) continue;
    since = now;
    {
      const Lock lock(mutex);
      ++counts.timeouts;
    }
    if (++timeouts == timeouts_before_reopening && options.reopen) {
      throw CaptureError(CaptureFault::time_out, "the camera delivers no frames any more");
    }
  }
}

// Until it is open, with growing pauses; false if it is told to stop.
bool Grabber::State::open_again() {
  double seconds = options.shortest_pause;
  while (!pause(seconds)) {
    try {
      device->open();
      clock.restart();
      const Lock lock(mutex);
      ++counts.reopened;
      return true;
    } catch (const CaptureError& fault) {
      device->close();
      if (!is_passing(fault.fault())) throw;
    }
    seconds = std::min(2 * seconds, options.longest_pause);
  }
  return false;
}

void Grabber::State::run() {
  device->open();
  for (bool is_open = true; is_open;) {
    try {
      return grab_until_fault();
    } catch (const CaptureError& fault) {
      if (!options.reopen || !is_passing(fault.fault())) throw;
    }
    device->close();
    is_open = open_again();
  }
}

void Grabber::grab(const std::shared_ptr<State>& state) {
  std::exception_ptr error;
  try {
    state->run();
  } catch (const std::exception&) {
    error = std::current_exception();
  }
  state->device->close();
  const Lock lock(state->mutex);
  state->error = error;
  state->has_ended = true;
  state->changed.notify_all();
}

Grabber::Grabber(std::shared_ptr<CaptureDevice> device, const GrabberOptions& options)
    : state_(std::make_shared<State>(std::move(device), options)),
      thread_(std::make_unique<std::thread>(start_thread([state = state_] { grab(state); }))) {}

Grabber::~Grabber() { close(); }

void Grabber::check_process() const {
  if (state_->process == process_id()) return;
  throw std::runtime_error(
      "the camera was opened in another process: after a fork, open it in the process that reads "
      "it");
}

std::optional<std::pair<int, int>> Grabber::wait_for_size(double timeout) const {
  check_process();
  Lock lock(state_->mutex);
  state_->wait(lock, timeout, [&] { return state_->seen.has_value(); });
  if (!state_->seen) state_->check();
  return state_->seen;
}

std::optional<Frame> Grabber::take(double timeout) {
  check_process();
  Lock lock(state_->mutex);
  state_->wait(lock, timeout, [&] { return state_->newest.has_value(); });
  if (state_->stops || !state_->newest) {
    state_->check();
    return std::nullopt;
  }
  ++state_->counts.delivered;
  state_->taken = std::exchange(state_->newest, std::nullopt);
  return state_->taken;
}

std::optional<Frame> Grabber::newest() const {
  check_process();
  const Lock lock(state_->mutex);
  return state_->taken;
}

CaptureCounts Grabber::counts() const {
  check_process();
  const Lock lock(state_->mutex);
  return state_->counts;
}

std::optional<std::pair<double, double>> Grabber::kept_rate() const {
  check_process();
  const Lock lock(state_->mutex);
  return state_->kept_rate;
}

void Grabber::close(double patience) noexcept {
  if (state_->process != process_id()) {
    // The thread is not here, and whoever had the mutex neither: nothing of it can be touched.
    if (thread_.release()) static_cast<void>(new std::shared_ptr<State>(state_));
    return;
  }
  std::unique_ptr<std::thread> thread;
  {
    const Lock lock(state_->mutex);
    state_->stops = true;
    thread = std::move(thread_);
    state_->changed.notify_all();
  }
  if (!thread) return;
  state_->device->interrupt();
  Lock lock(state_->mutex);
  const bool has_ended = state_->changed.wait_for(
      lock, Seconds(std::clamp(patience, 0.0, longest_wait)), [&] { return state_->has_ended; });
  state_->newest.reset();
  state_->taken.reset();
  lock.unlock();
  has_ended ? thread->join() : thread->detach();
}

}  // namespace robsim
