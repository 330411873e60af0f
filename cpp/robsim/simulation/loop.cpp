#include "robsim/simulation/loop.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <stdexcept>
#include <utility>

#include "robsim/base/system.hpp"
#include "robsim/simulation/seam/thread_guard.hpp"

namespace robsim {

namespace {

constexpr std::chrono::milliseconds between_beats{50};

// Says when to look up from the work: every 50 ms or so.
class Metronome {
 public:
  bool is_due(std::int64_t done) {
    if (done < next_look_) return false;
    const Clock::time_point now = Clock::now();
    // A look at the clock costs as much as a part of a step.
    between_looks_ =
        now - last_look_ < quick ? std::min(2 * between_looks_, most_between_looks) : 1;
    next_look_ = done + between_looks_;
    last_look_ = now;
    return now >= next_beat_;
  }

  void beat() { next_beat_ = Clock::now() + between_beats; }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds quick{1};  // for all the steps between two looks
  static constexpr std::int64_t most_between_looks = 64;

  Clock::time_point last_look_ = Clock::now();
  Clock::time_point next_beat_ = last_look_ + between_beats;
  std::int64_t next_look_ = 0;
  std::int64_t between_looks_ = 1;
};

// The time (s) of a step that came `gap` after the one before, at t.
double interval(double gap, double t, double dt, bool follows_stop) {
  // The robot stood still, as long as somebody liked: no multiple of dt, which estimators count in.
  if (follows_stop) return dt * std::max(1.0, std::round(gap / dt));
  // Frames that are dt apart are so but for rounding.
  return std::abs(gap - dt) < 1e-9 * std::max(1.0, t) ? dt : gap;
}

Stage after(Stage stage) {
  return stage == Stage::send ? Stage::world : static_cast<Stage>(static_cast<int>(stage) + 1);
}

}  // namespace

Loop::Loop(std::shared_ptr<World> world, const RobotOptions& robot, IdentifyFrom identify_from)
    : guard_(std::make_shared<RunGuard>()),
      world_(std::move(world)),
      camera_(world_),
      robot_(robot, guard_),
      samples_(identify_from) {
  world_->set_guard(guard_);
}

Stages& Loop::stages() {
  guard_->check_idle("a callback");
  return robot_.stages();
}

void Loop::set_observer(Observer observer) {
  guard_->check_idle("the observer");
  observer_ = std::move(observer);
}

void Loop::share(std::shared_ptr<Sights> sights) {
  guard_->check_idle("shared sights");
  sights_ = std::move(sights);
}

void Loop::start() {
  if (has_started()) return;
  const RunGuard::Run run(*guard_);
  prepare();
}

void Loop::prepare() {
  if (has_started()) return;
  robot_.start();
  try {
    world_->start(robot_.model());
  } catch (...) {
    robot_.reset();
    throw;
  }
  samples_.reset();
  is_interrupted_ = follows_stop_ = false;
  stage_.store(Stage::world, std::memory_order_release);
  // Before the first step the camera shows where it will begin.
  robot_.begin_step(0, robot_.model().dt(), {}, camera_);
}

void Loop::reset() {
  const RunGuard::Run run(*guard_);
  stop_robot();
  robot_.reset();
  world_->reset();
  recorder_.reset();
  stage_.store(Stage::world, std::memory_order_release);
}

bool Loop::run(std::int64_t steps, const Pulse& pulse, bool stops_robot) {
  const RunGuard::Run run(*guard_);
  prepare();
  recorder_.prepare(*world_, robot_, steps);
  resume();
  const bool is_alone = world_->is_live() && !is_interpreted();
  return is_alone ? turns_beside(steps, pulse, stops_robot) : turns(steps, pulse, stops_robot);
}

// Turns in a second thread, which needs no interpreter. This thread only looks up, and waits for
// the interpreter if another one has it.
bool Loop::turns_beside(std::int64_t steps, const Pulse& pulse, bool stops_robot) {
  const std::int64_t before = recorder_.rows();
  std::packaged_task<bool()> work([&] {
    const ThreadGuard::TakenOver run(*guard_);
    return turns(steps, [](std::int64_t) {}, stops_robot);
  });
  std::future<bool> is_at_end = work.get_future();
  std::thread thread = start_thread([&work] { work(); });
  const auto end = [&thread] {
    const NativeWork native;
    thread.join();
  };
  const auto is_over = [&is_at_end] {
    const NativeWork native;
    return is_at_end.wait_for(between_beats) == std::future_status::ready;
  };
  try {
    while (!is_over()) pulse(recorder_.rows() - before);
  } catch (...) {
    guard_->stop();
    end();
    throw;
  }
  end();
  return is_at_end.get();
}

bool Loop::turns(std::int64_t steps, const Pulse& pulse, bool stops_robot_after) {
  bool is_at_end = false;
  has_witness_ = robot_.stages().estimate_parameters || observer_ || is_interpreted();
  try {
    const auto estimator = robot_.hold_estimator();
    is_at_end = turn_on(steps, pulse);
  } catch (...) {
    write_sample();
    stop_robot();
    throw;
  }
  write_sample();
  if (stops_robot_after || is_at_end || guard_->is_stopped()) stop_robot();
  return is_at_end;
}

bool Loop::turn_on(std::int64_t steps, const Pulse& pulse) {
  std::unique_ptr<NativeWork> native;
  if (!is_interpreted()) native = std::make_unique<NativeWork>();
  Metronome metronome;
  for (std::int64_t done = 0; done < steps;) {
    if (stage_ == Stage::world && guard_->is_stopped()) break;
    const Arrival arrival = turn();
    if (arrival == Arrival::end) return true;
    if (arrival == Arrival::step) ++done;
    if (arrival == Arrival::step && !metronome.is_due(done)) continue;
    native.reset();
    write_sample();
    pulse(done);
    metronome.beat();
    if (!is_interpreted()) native = std::make_unique<NativeWork>();
  }
  return false;
}

std::optional<Stage> Loop::step_stage(const Pulse& pulse) {
  const RunGuard::Run run(*guard_);
  prepare();
  recorder_.prepare(*world_, robot_, 1);
  if (world_->was_stopped()) stop_robot();
  Stage done = Stage::world;
  has_witness_ = true;
  try {
    const auto estimator = robot_.hold_estimator();
    // One that was on when the stage before it was done may have been switched off.
    while (stage_ != Stage::world && !is_on(stage_)) do_stage();
    done = stage_;
    Arrival arrival = do_stage();
    for (; arrival == Arrival::nothing_yet; arrival = do_stage()) {
      if (guard_->is_stopped()) throw std::runtime_error("stop() was called before a frame came");
      pulse(0);
    }
    while (stage_ != Stage::world && !is_on(stage_)) do_stage();
    if (arrival == Arrival::end || guard_->is_stopped()) stop_robot();
    if (arrival == Arrival::end) return std::nullopt;
  } catch (...) {
    stop_robot();
    throw;
  }
  return done;
}

Arrival Loop::turn() {
  do {
    if (const Arrival arrival = do_stage(); arrival != Arrival::step) return arrival;
  } while (stage_.load(std::memory_order_relaxed) != Stage::world);
  return Arrival::step;
}

Arrival Loop::do_stage() {
  // A stage that throws is done again: nothing before it is done twice.
  const Stage stage = stage_.load(std::memory_order_relaxed);
  switch (stage) {
    case Stage::world:
      if (const Arrival arrival = begin_step(); arrival != Arrival::step) return arrival;
      break;
    case Stage::estimate_parameters:
      estimate_parameters();
      break;
    case Stage::measure:
      robot_.measure();
      break;
    case Stage::estimate_state:
      robot_.estimate_state();
      break;
    case Stage::control:
      robot_.control();
      break;
    case Stage::send:
      end_step();
      break;
  }
  stage_.store(after(stage), std::memory_order_release);
  return Arrival::step;
}

Arrival Loop::begin_step() {
  const std::int64_t k = recorder_.rows();
  observation_.clear();
  const Arrival arrival = world_->next(k, observation_);
  if (arrival != Arrival::step) return arrival;
  const double t = observation_.t, dt = robot_.model().dt();
  const double gap = k > 0 ? t - robot_.step()->t : dt;
  follows_stop_ = std::exchange(is_interrupted_, false) || observation_.interrupted;
  robot_.begin_step(k, interval(gap, t, dt, follows_stop_), observation_, camera_);
  if (const Truth* truth = world_->truth(); truth && sights_) {
    robot_.step()->known = sights_->at(*truth);
  }
  samples_.begin(*robot_.step(), robot_.model(), observation_.last_u, follows_stop_,
                 world_->is_live());
  return Arrival::step;
}

void Loop::estimate_parameters() {
  if (robot_.stages().estimate_parameters) {
    samples_.check_interval(*robot_.step(), robot_.model());
  }
  if (has_witness_) write_sample();
  robot_.estimate_parameters();
}

void Loop::write_sample() { samples_.write_newest(*robot_.step(), world_->truth()); }

void Loop::end_step() {
  Step& step = *robot_.step();
  std::optional<double> t_sent;
  if (step.u) {
    const Sent sent = world_->send(step.k, *step.u);
    t_sent = sent.t;
    step.u = sent.u;
    robot_.set_last_input(sent.u);
  }
  keep_step(t_sent);
}

void Loop::keep_step(const std::optional<double>& t_sent) {
  const StepPointer& step = robot_.step();
  const Truth* truth = world_->truth();
  if (truth && sights_) sights_->keep(*truth, *step);
  samples_.add(*step, truth);
  recorder_.record(*world_, robot_, observation_, t_sent, follows_stop_);
  if (observer_) observer_({step, observation_.t_arrival, t_sent, follows_stop_});
}

void Loop::resume() {
  if (world_->was_stopped()) stop_robot();
  if (!world_->is_live() || stage_ == Stage::world) return;
  // What was broken off is out of date: it is kept as far as it came, and its input is not sent.
  robot_.step()->u.reset();
  keep_step({});
  stage_.store(Stage::world, std::memory_order_release);
}

bool Loop::is_on(Stage stage) const {
  const Stages& stages = robot_.stages();
  return stage == Stage::world ||
         (stage == Stage::estimate_parameters && stages.estimate_parameters) ||
         (stage == Stage::measure && stages.measure) ||
         (stage == Stage::estimate_state && stages.estimate_state) ||
         (stage == Stage::control && stages.control);
}

const StepPointer& Loop::last_step() const {
  guard_->check_thread();
  if (!robot_.step()) throw std::runtime_error("there is no step before the start");
  return robot_.step();
}

void Loop::stop_robot_between_runs() {
  const RunGuard::Run run(*guard_);
  stop_robot();
}

void Loop::stop_robot() {
  if (const std::optional<Input> u = world_->stop()) {
    robot_.set_last_input(*u);
    is_interrupted_ = true;
  }
}

}  // namespace robsim
