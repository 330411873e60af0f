#include "robsim/lab/laboratory/laboratory.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "robsim/base/system.hpp"

namespace robsim {

namespace {

std::chrono::steady_clock::time_point time_point(double monotonic) {
  using Clock = std::chrono::steady_clock;
  return Clock::time_point(
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(monotonic)));
}

}  // namespace

Laboratory::Laboratory(std::shared_ptr<SimulatedWorld> world, const RobotModel& model,
                       std::shared_ptr<const ReceivedInput> input)
    : world_(std::move(world)), input_(std::move(input)), dt_(model.dt()), process_(process_id()) {
  world_->start(model);
}

Laboratory::~Laboratory() { close(); }

bool Laboratory::is_elsewhere() const { return process_ != process_id(); }

void Laboratory::start() {
  const std::lock_guard lock(mutex_);
  if (is_closed_) throw std::runtime_error("the laboratory is closed");
  if (has_started_) return;
  start_ = monotonic_now();
  move(0, {});
  thread_ = start_thread([this] { run(); });
  has_started_ = true;
}

void Laboratory::close() noexcept {
  {
    const std::lock_guard lock(mutex_);
    is_closed_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

double Laboratory::time_of(std::int64_t tick) const {
  return start_ + static_cast<double>(tick) * dt_;
}

std::int64_t Laboratory::first_tick_from(double time) const {
  return std::max<std::int64_t>(0, std::llround(std::ceil((time - start_) / dt_)));
}

void Laboratory::run() {
  try {
    std::unique_lock lock(mutex_);
    for (std::int64_t k = 1;; ++k) {
      changed_.wait_until(lock, time_point(time_of(k)), [this] { return is_closed_; });
      if (is_closed_) return;
      lock.unlock();
      const Input u = input_->mean(time_of(k - 1), time_of(k));
      lock.lock();
      move(k, u);
      changed_.notify_all();
    }
  } catch (const std::exception& error) {
    const std::lock_guard lock(mutex_);
    failure_ = error.what();
  }
  changed_.notify_all();
}

void Laboratory::move(std::int64_t k, const Input& u) {
  if (k > 0) world_->send(k - 1, u);
  Observation observation;
  world_->next(k, observation);
  const Truth& truth = *world_->truth();
  ticks_.push_back({time_of(k), truth.pose, u, truth.hidden, -1});
  if (ticks_.size() <= longest_record) return;
  ticks_.pop_front();
  ++first_;
}

Laboratory::Record Laboratory::record() const {
  const std::lock_guard lock(mutex_);
  return {first_, {ticks_.begin(), ticks_.end()}};
}

Laboratory::Tick Laboratory::tick(std::int64_t k) const {
  const std::lock_guard lock(mutex_);
  return ticks_.at(static_cast<std::size_t>(k - first_));
}

void Laboratory::set_shown(std::int64_t k, std::int64_t shown) {
  const std::lock_guard lock(mutex_);
  ticks_.at(static_cast<std::size_t>(k - first_)).shown = shown;
}

void Laboratory::stall(double seconds) { stalled_until_ = monotonic_now() + seconds; }

void Laboratory::unplug() {
  is_unplugged_ = true;
  wake();
}

void Laboratory::plug_in() { is_unplugged_ = false; }

bool Laboratory::wait_for(std::int64_t k, double due, double deadline,
                          const std::atomic<bool>& is_interrupted) const {
  std::unique_lock lock(mutex_);
  const auto is_disturbed = [&] {
    return is_interrupted || is_unplugged_ || is_closed_ || !failure_.empty();
  };
  changed_.wait_until(lock, time_point(std::min(due, deadline)), is_disturbed);
  changed_.wait_until(lock, time_point(deadline), [&] { return is_disturbed() || end() > k; });
  if (!failure_.empty()) throw std::runtime_error(failure_);
  if (is_closed_) throw std::runtime_error("the laboratory is closed");
  return !is_disturbed() && end() > k && monotonic_now() >= due;
}

void Laboratory::wake() const {
  {
    const std::lock_guard lock(mutex_);
  }  // nobody is between looking and waiting
  changed_.notify_all();
}

}  // namespace robsim
