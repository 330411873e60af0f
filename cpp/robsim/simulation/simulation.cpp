#include "robsim/simulation/simulation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "robsim/random/counter_random.hpp"

namespace robsim {

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds between_ticks{50};
constexpr std::chrono::milliseconds quick{1};  // for all the steps between two looks at the clock
constexpr std::int64_t most_steps_between_looks = 64;
constexpr std::int64_t most_rows_at_once = 1 << 16;  // a longer trace doubles its memory on the way

BlobOptions with_smoothing(BlobOptions blobs, const SimulationOptions& options) {
  if (options.smoothing) blobs.smoothing = *options.smoothing;
  return blobs;
}

void write(double* row, const Pose& pose) {
  row[0] = pose.x;
  row[1] = pose.y;
  row[2] = pose.heading;
}

}  // namespace

bool Dropout::hides(std::int64_t k) const {
  return probability > 0 &&
         random_uniform(seed, static_cast<std::uint64_t>(k / steps)) < probability;
}

// Marks the simulation as running for its life.
class Simulation::Busy {
 public:
  explicit Busy(Simulation& simulation) : simulation_(simulation) {
    if (simulation_.running_.exchange(true)) {
      throw std::runtime_error(
          "this simulation is already running: a callback or another thread cannot run it too");
    }
    simulation_.runner_ = std::this_thread::get_id();
  }
  ~Busy() {
    simulation_.interpreter_ = nullptr;
    simulation_.running_ = false;
  }
  Busy(const Busy&) = delete;
  Busy& operator=(const Busy&) = delete;

 private:
  Simulation& simulation_;
};

// Gives the interpreter up for its life, if the loop holds it.
class Simulation::NativeWork {
 public:
  explicit NativeWork(Simulation& simulation)
      : simulation_(simulation), interpreter_(std::exchange(simulation.interpreter_, nullptr)) {
    if (interpreter_) interpreter_->release();
  }
  ~NativeWork() {
    if (interpreter_) interpreter_->acquire();
    simulation_.interpreter_ = interpreter_;
  }
  NativeWork(const NativeWork&) = delete;
  NativeWork& operator=(const NativeWork&) = delete;

 private:
  Simulation& simulation_;
  Interpreter* interpreter_;
};

Simulation::Simulation(SimulationOptions options, Stages stages)
    : options_(std::move(options)),
      stages_(std::move(stages)),
      finder_(options_.colors, with_smoothing({}, options_)) {
  if (!is_finite(options_.start)) {
    throw std::invalid_argument("start must be a finite pose, got NaN or inf");
  }
}

Simulation::~Simulation() {
  if (step_) step_->source = nullptr;
}

Stages& Simulation::stages() {
  if (running_) throw std::runtime_error("a callback cannot be changed while the simulation runs");
  return stages_;
}

void Simulation::start() {
  if (has_started()) return;
  const Busy busy(*this);
  prepare();
}

void Simulation::prepare() {
  if (has_started()) return;
  RobotModel model = stages_.define_model();
  estimator_ = stages_.init_parameter_estimator(model);
  if (is_simulated()) renderer_.emplace(stages_.make_renderer());
  pose_ = options_.start;
  pose_.heading = wrap_angle(pose_.heading);
  last_pose_ = pose_;
  bounced_ = false;
  pan_ = {};
  input_ = {};
  held_.reset();
  parameters_.reset();
  past_ = {};
  next_stage_ = 0;
  has_begun_ = false;
  model_ = std::move(model);
  begin_step();
}

void Simulation::reset() {
  const Busy busy(*this);
  if (step_) step_->source = nullptr;
  step_.reset();
  model_.reset();
  estimator_.reset();
  renderer_.reset();
  trace_.clear();
  columns_ = {};
}

void Simulation::run(std::int64_t steps, Interpreter& interpreter) {
  const Busy busy(*this);
  prepare();
  add_columns();
  trace_.reserve(trace_.rows() + std::min(steps, most_rows_at_once));
  interpreter_ = &interpreter;
  std::optional<NativeWork> native;
  if (!needs_interpreter()) native.emplace(*this);
  Clock::time_point last_look = Clock::now();
  Clock::time_point next_tick = last_look + between_ticks;
  std::int64_t next_look = 0;
  std::int64_t between_looks = 1;  // a look costs as much as a part of a step
  for (std::int64_t done = 0; done < steps; ++done) {
    if (!turn()) break;
    if (done < next_look) continue;
    const Clock::time_point now = Clock::now();
    between_looks =
        now - last_look < quick ? std::min(2 * between_looks, most_steps_between_looks) : 1;
    next_look = done + between_looks;
    last_look = now;
    if (now < next_tick) continue;
    if (native) interpreter.acquire();
    struct Restore {
      Interpreter* held;
      ~Restore() {
        if (held) held->release();
      }
    } restore{native ? &interpreter : nullptr};
    interpreter.between_steps(done + 1);
    next_tick = Clock::now() + between_ticks;
  }
}

bool Simulation::turn() {
  // A turn that an exception cut short goes on where it stopped: nothing is done twice.
  using Stage = void (Simulation::*)();
  constexpr Stage stages[] = {&Simulation::estimate_parameters, &Simulation::measure,
                              &Simulation::estimate_state, &Simulation::control,
                              &Simulation::record};
  if (!has_begun_) {
    if (is_simulated()) {
      move_robot();
    } else if (!take_frame()) {
      return false;
    }
    has_begun_ = true;
  }
  for (; next_stage_ < std::size(stages); ++next_stage_) {
    const Stage stage = stages[next_stage_];
    (this->*stage)();
  }
  next_stage_ = 0;
  has_begun_ = false;
  return true;
}

bool Simulation::take_frame() {
  std::optional<Frame> frame = stages_.take_frame(trace_.rows());
  if (!frame) return false;
  const std::int64_t k = trace_.rows();
  const double dt = model_->dt();
  const double t = frame->t.value_or(static_cast<double>(k) * dt);
  const double gap = k > 0 ? t - step_->t : dt;
  if (!(gap > 0)) {
    throw std::invalid_argument("frames must come in the order of their times: that of step " +
                                std::to_string(k) + " is of t = " + std::to_string(t) +
                                " s, the one before of " + std::to_string(step_->t) + " s");
  }
  begin_step();
  step_->t = t;
  // Frames that are dt apart are so but for rounding.
  step_->dt = std::abs(gap - dt) < 1e-9 * std::max(1.0, t) ? dt : gap;
  step_->frame = std::move(*frame);
  return true;
}

void Simulation::begin_step() {
  if (step_ && !is_kept(step_)) {
    step_->forget();
  } else {
    if (step_) step_->source = nullptr;
    step_ = std::make_shared<Step>();
  }
  step_->k = trace_.rows();
  step_->dt = model_->dt();
  step_->t = static_cast<double>(step_->k) * step_->dt;
  step_->last_u = input_;
  step_->parameters = parameters_;
  step_->estimator = estimator_;
  step_->markers = options_.markers;
  step_->controller_seed = options_.controller_seed;
  step_->source = this;
}

bool Simulation::is_kept(const StepPointer& step) const { return step.use_count() > 1; }

void Simulation::move_robot() {
  const std::int64_t k = trace_.rows();
  Pose now = stages_.evaluate_model ? stages_.evaluate_model.call(world_state(k))
                                    : model_->predict(pose_, last_pose_, input_);
  now.heading = wrap_angle(now.heading);
  if (!is_finite(now)) {
    throw std::runtime_error("the robot's pose has grown beyond all bounds at step " +
                             std::to_string(k) + ": are the inputs bounded?");
  }
  last_pose_ = pose_;
  pose_ = now;
  bounced_ = options_.area.boundary == Boundary::bounce &&
             bounce(options_.area, options_.robot_radius, pose_, last_pose_);
  if (options_.area.boundary == Boundary::unlimited) move_view();
  begin_step();
}

WorldState Simulation::world_state(std::int64_t k) const {
  const double dt = model_->dt();
  return {k, static_cast<double>(k) * dt, dt, pose_, last_pose_, input_, *model_};
}

void Simulation::move_view() {
  const Point pixel = renderer_->camera().to_pixel({pose_.x, pose_.y});
  const double pixel_size = std::sqrt(renderer_->camera().area_scale({}));
  const double margin = 2 * options_.robot_radius / pixel_size;
  pan_ = follow(pan_, pixel, renderer_->width(), renderer_->height(), margin);
}

std::optional<Sample> Simulation::newest_sample() const {
  // From truth the sample of this step is complete; from the others that of the step before is.
  const bool from_truth = options_.identify_from == IdentifyFrom::truth;
  if (from_truth && !is_simulated()) return std::nullopt;
  const Past present{pose_, bounced_, {}};
  const Past& now = from_truth ? present : past_[0];
  const Past& last = from_truth ? past_[0] : past_[1];
  const Past& before = from_truth ? past_[1] : past_[2];
  if (!now.pose || !last.pose || !before.pose || now.bounced || last.bounced) return std::nullopt;
  return Sample{regression(*now.pose, *last.pose, *before.pose, last.u),
                step_->k - (from_truth ? 0 : 1)};
}

void Simulation::estimate_parameters() {
  step_->sample = newest_sample();
  if (!stages_.estimate_parameters) return;
  const std::optional<AxisMatrix> result = stages_.estimate_parameters.call(step_);
  if (result) parameters_ = result;
  step_->parameters = parameters_;
}

void Simulation::measure() {
  if (!stages_.measure) return;
  if (!stages_.measure.is_interpreted) blobs();
  step_->measurement = stages_.measure.call(step_);
  if (step_->frame) blobs();  // of a callback that has looked
  if (step_->measurement) held_ = step_->measurement->pose;
}

void Simulation::estimate_state() {
  if (!stages_.estimate_state) return;
  Estimate estimate = stages_.estimate_state.call(step_);
  const std::size_t size = estimate.state.size();
  if (size > 0 && trace_.column("state", size).width() != size) {
    throw std::invalid_argument("in the callback estimate_state at step " +
                                std::to_string(step_->k) + ": state must have " +
                                std::to_string(trace_.column("state", size).width()) +
                                " numbers at every step, got " + std::to_string(size));
  }
  step_->estimate = std::move(estimate);
}

void Simulation::control() {
  if (!stages_.control) return;
  const Input u = stages_.control.call(step_);
  step_->u = u;
  past_[2] = past_[1];
  past_[1] = past_[0];
  past_[0] = {std::nullopt, bounced_, u};
  switch (options_.identify_from) {
    case IdentifyFrom::truth:
      past_[0].pose = pose_;
      break;
    case IdentifyFrom::measurement:
      if (step_->measurement) past_[0].pose = step_->measurement->pose;
      break;
    case IdentifyFrom::estimate:
      if (step_->estimate) past_[0].pose = step_->estimate->pose;
      break;
  }
  input_ = u;
}

void Simulation::add_columns() {
  if (!is_simulated()) columns_.t = &trace_.column("t");
  if (is_simulated()) columns_.pose_true = &trace_.column("pose_true");
  if (stages_.control) columns_.u = &trace_.column("u");
  if (is_simulated()) columns_.bounced = &trace_.column("bounced");
  if (stages_.measure) {
    columns_.measured = &trace_.column("pose_measured");
    columns_.held = &trace_.column("pose_held");
    std::set<std::string> names;
    for (const ColorClass& color : options_.colors) names.insert(color.name);
    columns_.blobs.clear();
    for (const std::string& name : names) {
      columns_.blobs.push_back(&trace_.column("blobs_" + name, 4));
    }
  }
  if (stages_.estimate_parameters) {
    columns_.parameters = &trace_.column("parameters");
    if (estimator_->has_standard_errors())
      columns_.standard_errors_unscaled = &trace_.column("standard_errors_unscaled");
  }
  if (stages_.estimate_state) {
    columns_.estimated = &trace_.column("pose_estimated");
    columns_.covariance = &trace_.column("covariance");
  }
  if (is_simulated() && options_.area.boundary == Boundary::unlimited)
    columns_.view = &trace_.column("view");
}

void Simulation::record() {
  if (is_simulated()) {
    write(trace_.writable(*columns_.pose_true), pose_);
    *trace_.writable(*columns_.bounced) = bounced_;
  } else {
    *trace_.writable(*columns_.t) = step_->t;
  }
  if (columns_.u) {
    double* u = trace_.writable(*columns_.u);
    u[0] = input_.u1;
    u[1] = input_.u2;
  }
  if (parameters_ && columns_.parameters) {
    std::copy_n(parameters_->data(), 15, trace_.writable(*columns_.parameters));
  }
  if (columns_.standard_errors_unscaled)
    estimator_->write_standard_errors_unscaled(trace_.writable(*columns_.standard_errors_unscaled));
  if (columns_.view) {
    double* view = trace_.writable(*columns_.view);
    view[0] = renderer_->camera().matrix()[0] * pan_.u;
    view[1] = renderer_->camera().matrix()[4] * pan_.v;
  }
  record_measurement();
  record_estimate();
  trace_.append();
}

void Simulation::record_measurement() {
  if (step_->measurement) write(trace_.writable(*columns_.measured), step_->measurement->pose);
  if (held_ && columns_.held) write(trace_.writable(*columns_.held), *held_);
  if (!step_->blobs || columns_.blobs.empty()) return;
  auto column = columns_.blobs.begin();
  for (const auto& [color, blobs] : *step_->blobs) {
    double* positions = trace_.writable(**column++);
    for (std::size_t i = 0; i < std::min<std::size_t>(2, blobs.size()); ++i) {
      const Point position = step_->frame->plane_map.to_world(blobs[i].centroid);
      positions[2 * i] = position.x;
      positions[2 * i + 1] = position.y;
    }
  }
}

void Simulation::record_estimate() {
  if (!step_->estimate) return;
  const Estimate& estimate = *step_->estimate;
  write(trace_.writable(*columns_.estimated), estimate.pose);
  std::copy_n(estimate.covariance.data(), 9, trace_.writable(*columns_.covariance));
  if (estimate.state.empty()) return;
  double* state = trace_.writable(trace_.column("state", estimate.state.size()));
  std::copy(estimate.state.begin(), estimate.state.end(), state);
}

void Simulation::check_thread() const {
  if (running_ && runner_.load() != std::this_thread::get_id()) {
    throw std::runtime_error(
        "another thread is running this simulation: wait until it has finished");
  }
}

const StepPointer& Simulation::last_step() const {
  check_thread();
  if (!step_) throw std::runtime_error("this simulation has not started yet");
  return step_;
}

const Frame& Simulation::frame() {
  last_step();
  if (!step_->frame) step_->frame = draw_frame(step_->k, step_->t, pose_, pan_);
  return *step_->frame;
}

Frame Simulation::draw_frame(std::int64_t k, double t, const Pose& pose, const Pan& pan) {
  if (!renderer_) throw std::runtime_error("there is no frame yet: run a step");
  const NativeWork native(*this);
  Frame frame;
  frame.t = t;
  frame.index = k;
  frame.plane_map = renderer_->plane_map(pan);
  frame.image =
      renderer_->render(options_.dropout.hides(k) ? std::nullopt : std::optional(pose), pan);
  if (!options_.noise.is_off()) {
    Image noisy = noisy_images_.take(frame.image.width(), frame.image.height());
    options_.noise.add(frame.image.view(), options_.noise_seed, static_cast<std::uint64_t>(k),
                       noisy.writable_view());
    frame.image = noisy;
  }
  return frame;
}

Frame Simulation::render_step(std::int64_t k) {
  last_step();
  if (!is_simulated())
    throw std::runtime_error(
        "render_step needs a simulated world: frames that were given are not stored");
  if (k < 0 || k >= trace_.rows()) {
    throw std::out_of_range("there are steps 0.." + std::to_string(trace_.rows() - 1) +
                            ", got k = " + std::to_string(k));
  }
  const auto row = static_cast<std::size_t>(k);
  const double* pose = trace_.column("pose_true").memory()->data() + 3 * row;
  Pan pan;
  if (options_.area.boundary == Boundary::unlimited) {
    const double* view = trace_.column("view").memory()->data() + 2 * row;
    const PlaneMap::Matrix& camera = renderer_->camera().matrix();
    pan = {static_cast<int>(std::lround(view[0] / camera[0])),
           static_cast<int>(std::lround(view[1] / camera[4]))};
  }
  const double t = static_cast<double>(k) * model_->dt();
  return draw_frame(k, t, {pose[0], pose[1], pose[2]}, pan);
}

const BlobsByColor& Simulation::blobs() {
  last_step();
  if (!step_->blobs) {
    const NativeWork native(*this);
    suit_finder(frame());
    step_->blobs = finder_.find(step_->frame->image.view());
  }
  return *step_->blobs;
}

void Simulation::suit_finder(const Frame& frame) {
  const BlobOptions options = with_smoothing(
      marker_blobs(options_.markers, frame.plane_map, frame.image.width(), frame.image.height()),
      options_);
  if (!(options == finder_.options())) finder_ = BlobFinder(options_.colors, options);
}

bool Simulation::needs_interpreter() const {
  return !is_simulated() || stages_.evaluate_model.is_interpreted ||
         stages_.estimate_parameters.is_interpreted || stages_.measure.is_interpreted ||
         stages_.estimate_state.is_interpreted || stages_.control.is_interpreted ||
         (stages_.estimate_parameters && estimator_->is_interpreted());
}

}  // namespace robsim
